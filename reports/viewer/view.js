// 3D viewer of a solved scene. Every value that it displays comes from the results, stored in the page as JSON. The script element
// "view-data" contains what is drawn (lengths in mm): surfaces, positions of balls and rollers, contact points, and the reference.
// A "set" is one row of rolling elements: a ball nut or a bearing row.
"use strict";
(() => {
  const element = (id) => document.getElementById(id), read = (id) => JSON.parse(element(id).textContent);
  const data = read("view-data"), results = read("results"), flanks = data.flanks;
  const runs = results.cases ?? [results];
  const canvas = element("view-canvas"), shown = element("view-value"), curves = element("view-curves");
  const STEEL = "#c3c8ce", IDLE = "#eeeeee", ROLLER = "#b9bfc6", HALO = "#ff2d75", ARROW = ["#d1495b", "#d1495b", "#2f4b7c", "#2f4b7c"];
  const VIRIDIS = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];
  const QUANTITIES = [
    { key: "load_N", of: "load", unit: "N", title: "contact load" },
    { key: "pressure_MPa", of: "pressure", unit: "MPa", title: "peak pressure" },
    { key: "contact_angle_deg", of: "angle", unit: "°", title: "contact angle" },
  ];
  let caseAt = 0, setAt = -1, quantity = QUANTITIES[0];

  // ---- numbers

  const digits = (value, most = 4) => value == null || !isFinite(value) ? "–" : value === 0 ? "0" :
    Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3 ? value.toExponential(most - 1) :
    Math.abs(value) >= 10 ** (most - 1) ? Math.round(value).toString() : String(+value.toPrecision(most));
  const make = (tag, attributes = {}, ...children) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  };
  const several = () => data.cases[caseAt].sets.length > 1;
  const sets = () => data.cases[caseAt].sets.map((set, k) => ({ ...set, k, rows: rowsOf(k, set), rolling: Boolean(set.outline) }));
  /** Return the results of one set: a row for each ball or roller, in their order. */
  function rowsOf(k, set) {
    const run = runs[caseAt], rows = (set.outline ? run.rollers : run.balls) ?? [];
    return rows.filter((row) => row.set === undefined || row.set === k + 1);
  }
  const summaryOf = (k) => several() ? runs[caseAt].sets[k].summary : runs[caseAt].summary;
  /** Return the values of one ball at its flanks, or of one roller at its raceways. */
  function valuesOf(row, which = quantity) {
    const found = row[which.key];
    if (typeof found !== "object" || found === null) return [found ?? null];
    return flanks[0] in found ? flanks.map((side) => found[side]) : Object.values(found);
  }
  const largest = (values) => values.reduce((most, value) => value != null && value > (most ?? -Infinity) ? value : most, null);
  /** Return round ends of an axis that contains the values from low to high, and the positions of its labels. */
  function scale(low, high, count = 4) {
    if (!(high - low > 1e-3 * Math.abs(high))) [low, high] = high > 0 ? [0.9 * low, 1.1 * high] : [low - 1, high + 1];
    const rough = (high - low) / count, decade = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 2.5, 5, 10].map((m) => m * decade).find((s) => s >= rough * (1 - 1e-9));
    const first = Math.floor(low / step + 1e-9), last = Math.ceil(high / step - 1e-9);
    return { low: first * step, high: last * step, marks: [...Array(last - first + 1).keys()].map((i) => +((first + i) * step).toPrecision(12)) };
  }

  // ---- the scene in 3D

  let renderer = null;
  try {
    renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
  } catch {
    element("view-hint").textContent = "This browser cannot show the 3D model, because WebGL is missing. The diagrams contain all values.";
    canvas.parentElement.style.display = "none";
    document.querySelector(".paper")?.classList.remove("paper");
  }
  const camera = new THREE.PerspectiveCamera(24, 1, 1, 1e5), controls = renderer && new THREE.OrbitControls(camera, canvas);
  const world = new THREE.Scene(), sky = new THREE.HemisphereLight("#ffffff", "#8d939b", 1.5), lamp = new THREE.DirectionalLight("#ffffff", 2.0);
  world.add(sky, camera);
  camera.add(lamp);
  lamp.position.set(-0.5, 0.8, 1);
  const up = new THREE.Vector3(...data.up), sight = new THREE.Vector3(...data.sight);
  camera.up.copy(up);
  sky.position.copy(up);
  const kept = new Map(), steel = new Set(), outer = new Set();
  let bodies = [], rolling = [], arrows = [], halo = null, range = null;

  /** Return the mesh of a surface, shaded smoothly except at its edges. */
  function surface(given) {
    let geometry;
    if (given.outline) {
      geometry = new THREE.LatheGeometry(given.outline.map(([r, z]) => new THREE.Vector2(r, z)), 64).toNonIndexed();
      geometry.rotateX(Math.PI / 2);
    } else {
      const bytes = Uint8Array.from(atob(given.points), (c) => c.charCodeAt(0)), whole = new Uint16Array(bytes.buffer);
      const points = Float32Array.from(whole, (n, i) => given.low[i % 3] + given.step[i % 3] * n);
      const rows = given.rows, columns = points.length / 3 / rows, index = [];
      for (let i = 0; i + 1 < rows; i++) for (let j = 0; j + 1 < columns; j++) {
        const a = i * columns + j, b = a + columns;
        index.push(a, b, a + 1, a + 1, b, b + 1);
      }
      geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
      geometry.setIndex(index);
    }
    const mesh = new THREE.Mesh(THREE.toCreasedNormals(geometry, 0.6), new THREE.MeshLambertMaterial({ color: given.tint, side: THREE.DoubleSide }));
    (given.tint === STEEL ? steel : outer).add(mesh);
    return mesh;
  }

  function colourOf(value) {
    if (value == null || value === 0 && quantity.of !== "angle") return new THREE.Color(IDLE);
    const share = Math.min(Math.max((value - range.low) / (range.high - range.low), 0), 1) * (VIRIDIS.length - 1);
    const at = Math.min(Math.floor(share), VIRIDIS.length - 2);
    return new THREE.Color(VIRIDIS[at]).lerp(new THREE.Color(VIRIDIS[at + 1]), share - at);
  }
  const shownSets = () => sets().filter((set) => setAt < 0 || set.k === setAt);

  /** Build the balls, rollers, contact points and force arrows of the selected load case. */
  function build() {
    if (!renderer) return;
    world.remove(...bodies, ...rolling, ...arrows);
    for (const mesh of [...rolling, ...arrows]) mesh.dispose?.();
    bodies = data.cases[caseAt].surfaces.map((k) => kept.get(k) ?? kept.set(k, surface(data.surfaces[k])).get(k));
    rolling = [];
    arrows = [];
    for (const set of sets()) {
      const count = set.places.length, material = () => new THREE.MeshLambertMaterial({ color: "#ffffff" });
      const shape = set.rolling
        ? new THREE.LatheGeometry(set.outline.map(([r, z]) => new THREE.Vector2(r, z)), 24)
        : new THREE.SphereGeometry(set.radius, 32, 24);
      const mesh = new THREE.InstancedMesh(shape, material(), count);
      mesh.userData = { set, flank: null };
      set.places.forEach((place, i) => {
        const turn = new THREE.Quaternion();
        if (set.axes) turn.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...set.axes[i]));
        mesh.setMatrixAt(i, new THREE.Matrix4().compose(new THREE.Vector3(...place), turn, new THREE.Vector3(1, 1, 1)));
      });
      rolling.push(mesh);
      if (set.points) addContacts(set);
    }
    world.add(...bodies, ...rolling, ...arrows);
    colour();
  }
  /** Add a spot on the ball at each loaded contact, and the arrow of the contact force. */
  function addContacts(set) {
    const loaded = [];
    set.points.forEach((of, i) => of.forEach((point, s) => {
      const force = new THREE.Vector3(...set.forces[i][s]);
      if (force.length() > 0) loaded.push({ i, s, point: new THREE.Vector3(...point), force });
    }));
    if (!loaded.length) return;
    const most = Math.max(...loaded.map((one) => one.force.length())), one = new THREE.Vector3(1, 1, 1), y = new THREE.Vector3(0, 1, 0);
    const spots = new THREE.InstancedMesh(new THREE.SphereGeometry(0.26 * set.radius, 16, 12), new THREE.MeshLambertMaterial(), loaded.length);
    const outline = [[0, 0], [0.03, 0], [0.03, 0.72], [0.075, 0.72], [0, 1]].map(([r, z]) => new THREE.Vector2(r, z));
    const heads = new THREE.InstancedMesh(new THREE.LatheGeometry(outline, 12), new THREE.MeshLambertMaterial({ side: THREE.DoubleSide }), loaded.length);
    loaded.forEach(({ i, s, point, force }, n) => {
      const centre = new THREE.Vector3(...set.places[i]), inside = point.clone().lerp(centre, 0.13);
      spots.setMatrixAt(n, new THREE.Matrix4().compose(inside, new THREE.Quaternion(), one));
      const long = 3.6 * set.radius * force.length() / most, along = force.clone().normalize();
      const turn = new THREE.Quaternion().setFromUnitVectors(y, along), size = new THREE.Vector3(3.6 * set.radius, long, 3.6 * set.radius);
      heads.setMatrixAt(n, new THREE.Matrix4().compose(point.clone().addScaledVector(along, -long), turn, size));
      heads.setColorAt(n, new THREE.Color(ARROW[s]));
    });
    spots.userData = { set, loaded };
    heads.userData = set;
    rolling.push(spots);
    arrows.push(heads);
  }
  /** Colour balls and rollers by the selected quantity, and draw the colour scale, which covers the sets that are shown. */
  function colour() {
    const values = shownSets().flatMap((set) => set.rows.map((row) => largest(valuesOf(row)))).filter((v) => v != null && (v > 0 || quantity.of === "angle"));
    range = values.length ? scale(Math.min(...values), Math.max(...values)) : null;
    const bar = element("view-scale");
    bar.replaceChildren();
    if (range) {
      const stripe = make("div", { class: "bar", style: `background: linear-gradient(to right, ${VIRIDIS.join(", ")})` });
      const marks = make("div", { class: "marks" }, ...[range.low, (range.low + range.high) / 2, range.high].map((v) => make("span", {}, digits(v))));
      bar.append(`${quantity.title} / ${quantity.unit}`, stripe, marks);
    }
    if (!renderer) return;
    for (const mesh of rolling) {
      const { set, loaded } = mesh.userData, dim = setAt >= 0 && set.k !== setAt;
      for (let n = 0; n < mesh.count; n++) {
        const row = set.rows[loaded ? loaded[n].i : n], of = row ? valuesOf(row) : [null];
        const value = loaded ? of[loaded[n].s] : largest(of);
        mesh.setColorAt(n, dim || !range ? new THREE.Color(set.rolling ? ROLLER : IDLE) : colourOf(value));
      }
      mesh.instanceColor.needsUpdate = true;
    }
    show();
  }
  function show() {
    if (!renderer) return;
    const forces = element("view-forces").checked;
    for (const mesh of outer) mesh.visible = element("view-outer").checked;
    for (const mesh of arrows) mesh.visible = forces && (setAt < 0 || mesh.userData.k === setAt);
    for (const { material } of [...steel, ...outer]) {  // transparent, because the arrows of the screw's forces begin inside it
      Object.assign(material, { transparent: forces, opacity: forces ? 0.35 : 1, depthWrite: !forces });
      material.needsUpdate = true;
    }
    element("view-outer").parentElement.hidden = !outer.size;
    element("view-forces").parentElement.hidden = !arrows.length;
    draw();
  }
  let asked = false;
  /** Request one drawing in the next frame, however often it is called before that. */
  function draw() {
    if (!renderer || asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      renderer.render(world, camera);
    });
  }
  /** Point the camera at the selected set, or at all sets. */
  function aim() {
    if (!renderer) return;
    const seen = shownSets(), middle = new THREE.Vector3();
    const low = Math.min(...seen.map((s) => s.centre[2] - s.size / 2)), high = Math.max(...seen.map((s) => s.centre[2] + s.size / 2));
    middle.z = (low + high) / 2;
    const tall = Math.max(...seen.map((s) => s.size)), wide = Math.max((high - low) * 1.12, tall * 1.25);
    const half = Math.tan(camera.fov * Math.PI / 360), far = Math.max(tall * 0.6 / half, wide / 2 / (half * camera.aspect)) + tall / 2;
    controls.target.copy(middle);
    camera.position.copy(middle).addScaledVector(sight, far);
    camera.near = far / 200;
    camera.far = far * 60;
    camera.updateProjectionMatrix();
    controls.update();
    draw();
  }
  function resize() {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!width || !renderer) return;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    const turned = Math.abs(camera.aspect - width / height) > 0.2;
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    turned ? aim() : draw();
  }

  // ---- values under the pointer

  /** Return the ball or roller at a point of the canvas: its set, its index from 0, and the flank of a contact or null. */
  function under(x, y) {
    if (!renderer) return null;
    const ray = new THREE.Raycaster(), box = canvas.getBoundingClientRect();
    ray.setFromCamera(new THREE.Vector2(2 * (x - box.left) / box.width - 1, 1 - 2 * (y - box.top) / box.height), camera);
    const hit = ray.intersectObjects(rolling, false)[0];
    if (!hit) return null;
    ray.far = hit.distance;
    if (ray.intersectObjects(bodies.filter((body) => body.visible && !body.material.transparent), false).length) return null;
    const { set, loaded } = hit.object.userData;
    return loaded ? { set, ball: loaded[hit.instanceId].i, flank: loaded[hit.instanceId].s } : { set, ball: hit.instanceId, flank: null };
  }
  /** Return the results of one ball or roller as a small table. */
  function told({ set, ball, flank }) {
    const row = set.rows[ball], table = make("table"), head = `${set.name ? `${set.name}, ` : ""}${set.rolling ? "roller" : "ball"} ${row.index}`;
    const line = (name, cells) => table.append(make("tr", {}, make("td", {}, name), ...cells.map((cell) => make("td", {}, cell))));
    if (set.rolling) {
      line("load", [`${digits(row.load_N, 5)} N`]);
      for (const [race, value] of Object.entries(row.pressure_MPa ?? {})) line(race, [`${digits(value)} MPa`]);
      return [make("b", {}, head), table];
    }
    const touching = flanks.filter((side, s) => flank === null ? row.load_N[side] > 0 : s === flank);
    for (const side of touching) {
      const cells = [`${digits(row.load_N[side], 5)} N`, `${digits(row.pressure_MPa[side], 5)} MPa`, `${digits(row.contact_angle_deg[side], 4)}°`];
      const error = set.reference?.error[ball]?.[flanks.indexOf(side)];
      line(side, error == null ? cells : [...cells, `error ${digits(error, 3)} %`]);
    }
    return [make("b", {}, head), ...(touching.length ? [table] : [" carries no load"])];
  }
  function point(found, x, y) {
    shown.hidden = !found || !found.set.rows[found.ball];
    mark(found);
    if (shown.hidden) return;
    shown.replaceChildren(...told(found));
    const box = shown.parentElement.getBoundingClientRect(), room = box.width - shown.offsetWidth - 8;
    shown.style.left = `${Math.max(4, Math.min(x - box.left + 14, room))}px`;
    shown.style.top = `${Math.max(4, Math.min(y - box.top + 12, box.height - shown.offsetHeight - 6))}px`;
  }
  /** Highlight a ball or roller in the 3D model and in the diagrams. */
  function mark(found) {
    for (const line of curves.querySelectorAll(".at")) line.style.display = "none";
    if (found) for (const line of curves.querySelectorAll(`.at[data-set="${found.set.k}"]`)) {
      const x = line.dataset.from * 1 + line.dataset.step * found.ball;
      line.setAttribute("x1", x);
      line.setAttribute("x2", x);
      line.style.display = "";
    }
    if (!renderer || !halo && !found) return;
    if (halo) world.remove(halo);
    halo = null;
    if (found && !found.set.rolling) {
      halo = new THREE.Mesh(new THREE.SphereGeometry(1.13 * found.set.radius, 32, 24), new THREE.MeshBasicMaterial({ color: HALO, side: THREE.BackSide }));
      halo.position.set(...found.set.places[found.ball]);
      world.add(halo);
    }
    draw();
  }

  // ---- curves

  const SVG = "http://www.w3.org/2000/svg", WIDE = 420, HIGH = 190, LEFT = 46, FOOT = 30, TOP = 8, RIGHT = 8;
  function drawn(tag, attributes, text) {
    const made = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (text !== undefined) made.textContent = text;
    return made;
  }
  /** Return, for each flank, the values of one quantity of the results for all balls. */
  const byFlank = (set, key) => flanks.map((side) => set.rows.map((row) => row[key]?.[side] ?? null));
  const columns = (rows) => flanks.map((_, s) => rows.map((row) => row[s]));
  const touched = (set, s) => set.rows.some((row) => row.load_N?.[flanks[s]] > 0);
  /** Return the diagrams of one set: title, unit and curves of each. */
  function panels(set) {
    if (set.rolling) {
      const races = Object.keys(set.rows[0]?.pressure_MPa ?? {});
      return [
        { title: "Load", unit: "N", zero: true, series: [{ name: "rollers", y: set.rows.map((row) => row.load_N), c: 0 }] },
        { title: "Largest pressure", unit: "MPa", zero: true, series: races.map((race, c) => ({ name: race, y: set.rows.map((row) => row.pressure_MPa[race]), c })) },
      ];
    }
    const lines = (values, pick = touched) => values.map((y, s) => ({ name: flanks[s], y, c: s })).filter(({ c }) => pick(set, c));
    const load = lines(byFlank(set, "load_N")), found = [{ title: "Contact load", unit: "N", zero: true, series: load, band: set.expected }];
    if (set.reference) {
      const { label, load: loads, uncertainty } = set.reference, bars = columns(uncertainty);
      load.push(...lines(columns(loads)).map((one) => ({ ...one, name: label, dots: true, bars: bars[one.c] })));
    }
    found.push({ title: "Peak pressure", unit: "MPa", zero: true, series: lines(byFlank(set, "pressure_MPa")) });
    if (set.reference)
      found.push({ title: `Error against the ${set.reference.label}`, unit: "% of the mean load", zero: true, series: lines(columns(set.reference.error)) });
    if (set.closer) found.push({ title: "Reduction of clearance by errors of the parts", unit: "µm", zero: true, series: lines(columns(set.closer), () => true) });
    return found;
  }
  function panel(set, { title, unit, series, zero, band }) {
    const all = series.flatMap(({ y, bars }) => y.flatMap((v, i) => v == null ? [] : [v, ...(bars ? [v - bars[i], v + bars[i]] : []), ...(band ? [v + band] : [])]));
    const figure = make("figure"), caption = make("figcaption", {}, make("b", {}, `${title} / ${unit}`));
    const names = new Set();
    for (const { name, c, dots } of series) {
      if (names.has(name)) continue;
      names.add(name);
      const style = dots ? "border-color: var(--view-ink)" : `color: var(--flank-${c})`;
      caption.append(make("span", {}, make("i", { style, class: dots ? "dot" : c > 1 ? "dashed" : "" }), name));
    }
    if (band) caption.append(make("span", {}, make("i", { class: "band" }), "expected error"));
    figure.append(caption);
    if (!all.length) return figure;
    const ends = scale(Math.min(...all, ...(zero ? [0] : [])), Math.max(...all, ...(zero ? [0] : [])));
    const count = set.rows.length, step = (WIDE - LEFT - RIGHT) / Math.max(count - 1 + 0.6, 1), from = LEFT + 0.3 * step;
    const x = (i) => from + step * i, y = (v) => TOP + (HIGH - TOP - FOOT) * (ends.high - v) / (ends.high - ends.low);
    const svg = drawn("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, role: "img", "aria-label": title });
    for (const v of ends.marks) {
      svg.append(drawn("line", { class: "grid", x1: LEFT, x2: WIDE - RIGHT, y1: y(v), y2: y(v) }));
      svg.append(drawn("text", { x: LEFT - 5, y: y(v) + 4, "text-anchor": "end" }, digits(v)));
    }
    const each = Math.max(1, scale(1, Math.max(count, 2), 8).marks[1] - scale(1, Math.max(count, 2), 8).marks[0]);
    for (let n = 1; n <= count; n++) if (n === 1 || n % Math.ceil(each) === 0 && n > 0.7 * each) svg.append(drawn("text", { x: x(n - 1), y: HIGH - 16, "text-anchor": "middle" }, n));
    svg.append(drawn("text", { x: (LEFT + WIDE) / 2, y: HIGH - 2, "text-anchor": "middle" }, set.rolling ? "roller" : "ball"));
    if (band) for (const { y: values, c, dots } of series) {
      if (dots) continue;
      const edge = (sign) => values.map((v, i) => `${x(i).toFixed(1)},${y(Math.max((v ?? 0) + sign * band, zero ? 0 : -Infinity)).toFixed(1)}`);
      svg.append(drawn("polygon", { points: [...edge(1), ...edge(-1).reverse()].join(" "), style: `fill: var(--flank-${c})`, opacity: 0.13 }));
    }
    for (const { y: values, c, dots, bars } of series) {
      const places = values.map((v, i) => v == null ? null : [x(i), y(v)]), style = `stroke: var(--flank-${c}); fill: none`;
      if (dots) {
        places.forEach((p, i) => p && svg.append(drawn("circle", { cx: p[0], cy: p[1], r: 2.6, style }),
          drawn("line", { x1: p[0], x2: p[0], y1: y(values[i] - bars[i]), y2: y(values[i] + bars[i]), style })));
        continue;
      }
      let path = "", open = false;
      for (const p of places) {
        path += p ? `${open ? "L" : "M"}${p[0].toFixed(1)} ${p[1].toFixed(1)}` : "";
        open = Boolean(p);
      }
      svg.append(drawn("path", { d: path, style, "stroke-width": 1.6, ...(c > 1 ? { "stroke-dasharray": "5 4" } : {}) }));
      if (count <= 80) for (const p of places) if (p) svg.append(drawn("circle", { cx: p[0], cy: p[1], r: 1.7, style: `fill: var(--flank-${c})` }));
    }
    svg.append(drawn("line", { class: "at", "data-set": set.k, "data-from": from, "data-step": step, y1: TOP, y2: HIGH - FOOT, style: "display: none" }));
    svg.addEventListener("pointermove", (event) => {
      const box = svg.getBoundingClientRect(), at = Math.round(((event.clientX - box.left) / box.width * WIDE - from) / step);
      const found = { set, ball: Math.min(Math.max(at, 0), count - 1), flank: null }, stage = canvas.parentElement.getBoundingClientRect();
      point(found, stage.left, stage.top);
    });
    svg.addEventListener("pointerleave", () => point(null));
    figure.append(svg);
    return figure;
  }
  /** Return a table of all sets; a click on a name selects the set. */
  function table() {
    const head = ["nut or bearing row", "largest load / N", "pressure / MPa", "safety", "L10 / 10⁶ rev"];
    const made = make("table", { class: "sets" }, make("thead", {}, make("tr", {}, ...head.map((text) => make("th", { scope: "col" }, text)))));
    const body = make("tbody");
    for (const set of sets()) {
      const s = summaryOf(set.k), button = make("button", { type: "button" }, set.name);
      button.addEventListener("click", () => choose(caseAt, set.k));
      const cells = [s.loads?.max_N, s.worst_contact?.pressure_MPa, s.static_safety?.factor, s.life?.L10_million_revolutions];
      body.append(make("tr", {}, make("th", { scope: "row" }, button), ...cells.map((value) => make("td", {}, digits(value)))));
    }
    made.append(body);
    return made;
  }

  // ---- the page

  /** Show the main results above the 3D model: label, value, unit and a remark of each. */
  function answers() {
    const run = runs[caseAt], s = setAt < 0 ? run.summary : summaryOf(setAt), form = setAt < 0 || !several() ? run.model_form : null;
    const whole = several() && setAt < 0, of = whole && s.worst_set ? data.cases[caseAt].sets[s.worst_set - 1].name : "";
    const worst = s.worst_contact, ofLoad = (setAt < 0 || !several()) && s.load_point, number = worst && (worst.ball ?? worst.roller);
    const rows = [
      ["status", runs[caseAt].status, "", ""],
      ["nut or row with the worst contact", of || null, "", ""],
      ["largest contact load", whole ? null : s.loads?.max_N, "N", s.loads?.worst_ball ? `ball ${s.loads.worst_ball} ${s.loads.worst_side}` : ""],
      ["mean contact load", whole ? null : s.loads?.mean_N, "N", ""],
      ["largest pressure", worst?.pressure_MPa, "MPa", number ? `${worst.ball ? "ball" : "roller"} ${number}` : ""],
      ["static safety", s.static_safety?.factor, "", ""],
      ["axial displacement of nut or bearing", s.nut?.displacement_um, "µm", ""],
      ["displacement of the load's point", ofLoad?.displacement_um, "µm", ofLoad?.at],
      ["life L10", s.life?.L10_million_revolutions, "10⁶ rev", of],
      ["expected error of a load", form?.largest_percent_of_mean && +form.largest_percent_of_mean.toPrecision(2), "% of mean", ""],
    ];
    element("view-answers").replaceChildren(...rows.filter(([, value]) => value != null).map(([label, value, unit, after]) =>
      make("div", {}, make("dt", {}, label), make("dd", {}, typeof value === "string" ? value : digits(value), make("small", {}, ` ${unit} ${after}`)))));
    element("view-warnings").replaceChildren(...(run.warnings ?? []).map((text) => make("li", {}, text)));
  }
  function tabs(id, names, at, pick) {
    element(id).replaceChildren(...(names.length < 2 ? [] : names.map((name, k) => {
      const made = make("button", { type: "button", role: "tab", "aria-selected": String(k === at) }, name);
      made.addEventListener("click", () => pick(k));
      return made;
    })));
  }
  /** Show a load case, and one of its sets or, for -1, all of them. */
  function choose(toCase, toSet, aimed = true) {
    const rebuilt = toCase !== caseAt || !bodies.length;
    [caseAt, setAt] = [toCase, several() ? toSet : 0];
    tabs("view-cases", data.cases.map((one) => one.name), caseAt, (k) => choose(k, setAt, false));
    tabs("view-sets", several() ? ["all", ...data.cases[caseAt].sets.map((one) => one.name)] : [], setAt + 1, (k) => choose(caseAt, k - 1));
    shown.hidden = true;
    answers();
    rebuilt ? build() : colour();
    const set = sets()[setAt];
    curves.replaceChildren(...(set ? panels(set).map((one) => panel(set, one)) : [table()]));
    if (aimed) aim();
  }
  const chooser = element("view-quantity"), kinds = new Set(data.cases.flatMap((one) => one.sets.map((set) => set.kind)));
  chooser.replaceChildren(...QUANTITIES.map((one) => make("option", { value: one.key }, one.of)));
  chooser.addEventListener("change", () => {
    quantity = QUANTITIES[chooser.selectedIndex];
    colour();
  });
  element("view-outer").nextElementSibling.textContent = kinds.size > 1 ? "nuts and outer rings" : kinds.has("ball nut") ? "nut" : "outer ring";
  for (const id of ["view-outer", "view-forces"]) element(id).addEventListener("change", show);
  element("view-reset").addEventListener("click", aim);
  let pressed = false;
  canvas.addEventListener("pointerdown", (event) => {
    pressed = true;
    point(under(event.clientX, event.clientY), event.clientX, event.clientY);
  });
  addEventListener("pointerup", () => { pressed = false; });
  canvas.addEventListener("pointermove", (event) => {
    if (pressed) point(null);
    else point(under(event.clientX, event.clientY), event.clientX, event.clientY);
  });
  canvas.addEventListener("pointerleave", () => point(null));
  controls?.addEventListener("change", draw);
  new ResizeObserver(resize).observe(canvas);
  choose(0, several() ? -1 : 0, false);
  resize();
  aim();
})();
