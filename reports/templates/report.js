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

  // a folded table that an address names, or that is printed, opens
  const unfold = () => {
    const table = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const fold = table && table.querySelector("details");
    if (fold) { fold.open = true; table.scrollIntoView(); }
  };
  addEventListener("hashchange", unfold);
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((fold) => { fold.open = true; }));
  unfold();

  // on a phone a table that is wider than the page shows each row as a list of headings and values
  const phone = matchMedia("(max-width: 640px)");
  const list = (box) => {
    const table = box.querySelector("table");
    if (!phone.matches || !table || table.classList.contains("list") || box.scrollWidth <= box.clientWidth + 2) return;
    const heads = [...table.querySelectorAll("th")].map((head) => head.textContent.trim());
    table.querySelectorAll("tbody tr").forEach((row) => [...row.cells].forEach((cell, k) => {
      cell.dataset.head = heads[k];
      cell.classList.toggle("empty", cell.textContent.trim() === "–");
    }));
    table.classList.add("list");
  };

  // a sign at tables that are wider than the page
  const clip = () => document.querySelectorAll(".scroll").forEach((box) => {
    list(box);
    box.parentElement.classList.toggle("more", box.scrollLeft + box.clientWidth < box.scrollWidth - 2);
  });
  document.querySelectorAll(".scroll").forEach((box) => box.addEventListener("scroll", clip, { passive: true }));
  addEventListener("resize", clip);
  document.querySelectorAll("details").forEach((fold) => fold.addEventListener("toggle", clip));
  clip();
})();
