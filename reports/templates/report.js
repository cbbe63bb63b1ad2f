"use strict";
(() => {
  const root = document.documentElement, $ = (id) => document.getElementById(id);

  // light or dark: the system's choice until somebody chooses
  $("theme").addEventListener("click", () => {
    const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    try { localStorage.setItem("rollbench-theme", root.dataset.theme); } catch (e) { /* private window */ }
  });

  // contents on a narrow screen
  const menu = $("menu"), contents = $("contents");
  const open = (on) => { contents.classList.toggle("open", on); menu.setAttribute("aria-expanded", String(on)); };
  menu.addEventListener("click", () => open(!contents.classList.contains("open")));
  contents.addEventListener("click", (event) => { if (event.target.closest("a")) open(false); });
  const here = contents.querySelector("[aria-current]");
  if (here && contents.scrollHeight > contents.clientHeight) contents.scrollTop = here.offsetTop - 80;

  // search: every word must occur; titles count more than text
  const hits = $("hits"), query = $("query");
  const plain = (text) => text.toLowerCase().replaceAll("µ", "u");
  function find() {
    const words = plain(query.value).split(/\s+/).filter(Boolean);
    const found = [];
    for (const entry of words.length ? window.rollbenchSearch || [] : []) {
      const title = plain(entry.t), all = `${title} ${plain(entry.x)}`;
      if (words.every((word) => all.includes(word))) found.push([words.filter((word) => title.includes(word)).length, entry]);
    }
    found.sort((a, b) => b[0] - a[0]);
    hits.replaceChildren(...found.slice(0, 12).map(([, entry]) => {
      const line = document.createElement("li"), link = document.createElement("a"), place = document.createElement("small");
      link.href = entry.h; link.textContent = entry.t; place.textContent = entry.s;
      link.append(place); line.append(link);
      return line;
    }));
    if (words.length && !found.length) hits.append(Object.assign(document.createElement("li"), { textContent: "nothing found" }));
    hits.hidden = !words.length;
  }
  query.addEventListener("input", find);
  query.addEventListener("focus", find);
  document.addEventListener("click", (event) => { if (!event.target.closest(".search")) hits.hidden = true; });
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape") hits.hidden = true;
    if (event.key === "Enter" && event.target === query) hits.querySelector("a")?.click();
    if (event.key === "/" && event.target === document.body) { event.preventDefault(); query.focus(); }
  });

  // a sign at tables that are wider than the page
  const clip = () => document.querySelectorAll(".scroll").forEach((box) => {
    box.parentElement.classList.toggle("more", box.scrollLeft + box.clientWidth < box.scrollWidth - 2);
  });
  document.querySelectorAll(".scroll").forEach((box) => box.addEventListener("scroll", clip, { passive: true }));
  addEventListener("resize", clip);
  clip();

  // values under the pointer: those of the nearest point of a drawing
  const tip = document.body.appendChild(Object.assign(document.createElement("div"), { className: "tip", hidden: true }));
  tip.setAttribute("role", "status");
  document.querySelectorAll("svg .values").forEach((group) => {
    const points = [...group.children].map((circle) => {
      const title = circle.firstElementChild, [name, x, y] = title.textContent.split("\n");
      const text = `${name}\n${group.dataset.x}: ${x}\n${group.dataset.y}: ${y}`;
      title.remove(); // the browser would show it too, later
      return { x: +circle.getAttribute("cx"), y: +circle.getAttribute("cy"), text, circle };
    });
    const svg = group.ownerSVGElement;
    let last = null;
    const leave = () => { tip.hidden = true; last?.classList.remove("on"); last = null; };
    svg.addEventListener("pointermove", (event) => {
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      let best = null, least = 14 ** 2;
      for (const point of points) {
        const away = (point.x - at.x) ** 2 + (point.y - at.y) ** 2;
        if (away < least) [best, least] = [point, away];
      }
      leave();
      if (!best) return;
      last = best.circle;
      last.classList.add("on");
      tip.textContent = best.text;
      tip.hidden = false;
      tip.style.left = `${Math.max(4, Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8))}px`;
      tip.style.top = `${Math.max(4, event.clientY - tip.offsetHeight - 12)}px`;
    });
    svg.addEventListener("pointerleave", leave);
  });
})();
