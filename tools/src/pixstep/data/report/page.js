// SPDX-License-Identifier: MIT
// Draws the report: the map of the job, and six drawings of one line of one motor.
"use strict";

(async () => {
  const byId = (id) => document.getElementById(id);
  const about = JSON.parse(byId("about").textContent);
  const {lines, pixels, motors, fates, image} = about;
  const FATES = [
    ["not printed", "#c3cad2", ""], ["printed", "#1a7f4b", "green"],
    ["skipped", "#e0a100", "amber"], ["in flight", "#1767b5", "blue"],
    ["begun, and printed again", "#d1495b", "amber"],
  ];
  const NO_FIGURE = [217, 212, 201];
  const RAMP = [[237, 244, 251], [158, 202, 225], [66, 146, 198], [8, 88, 158], [8, 36, 82]];
  const number = new Intl.NumberFormat("en", {maximumFractionDigits: 4});
  const arrays = await unpacked(byId("data").textContent.trim());

  async function unpacked(text) {
    const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const buffer = await new Response(stream).arrayBuffer();
    const kinds = {int8: Int8Array, int16: Int16Array, int32: Int32Array};
    return Object.fromEntries(about.arrays.map(
      ({name, type, at, count}) => [name, new kinds[type](buffer, at, count)]));
  }

  // A line of a motor has a place in the arrays of runs; figures that some lines have, a row.
  const placeOf = (line, motor) => (line - 1) * motors.length + motor;
  const lowest = (values) => -(2 ** (8 * values.BYTES_PER_ELEMENT - 1));

  function rowOf(name, rows, place) {
    const values = arrays[name], row = arrays[rows] ? arrays[rows][place] : -1;
    return row < 0 ? null : values.subarray(row * pixels, (row + 1) * pixels);
  }

  function speeds(place) {
    const from = arrays.shape[place] * pixels, sign = arrays.sign[place];
    return Float64Array.from(arrays.counts.subarray(from, from + pixels), (count) => sign * count);
  }

  const MAPS = [
    {key: "speed", name: "speed", unit: "steps/px", row: speeds},
    {key: "error", name: "edge error", unit: "ticks", row: (p) => rowOf("error", "row", p)},
    {key: "off", name: "actual − expected", unit: "steps", row: (p) => rowOf("actual", "row", p)},
    {key: "measured", name: "measured − expected", unit: "steps",
      row: (p) => rowOf("measured", "measured_row", p)},
  ].filter(({key}) => key === "speed" || (arrays[key === "off" ? "actual" : key] || []).length);

  // What is shown, kept in the address so that a page that reloads itself shows the same.
  const asked = new URLSearchParams(location.hash.slice(1));
  const named = motors.findIndex(({name}) => name === asked.get("motor"));
  const shown = {
    line: clamp(Number(asked.get("line")) || firstLine(), 1, lines),
    motor: Math.max(0, named),
    map: Math.max(0, MAPS.findIndex(({key}) => key === asked.get("map"))),
    from: clamp(Number(asked.get("from")) || 0, 0, pixels),
    to: clamp(Number(asked.get("to")) || pixels, 1, pixels),
  };
  if (shown.from >= shown.to) [shown.from, shown.to] = [0, pixels];

  function firstLine() {
    const flying = fates.indexOf(3);
    return flying < 0 ? 1 : flying + 1;
  }

  function clamp(value, low, high) { return Math.min(Math.max(value, low), high); }

  function keep() {
    const {line, from, to} = shown;
    const facts = {line, motor: motors[shown.motor].name, map: MAPS[shown.map].key, from, to};
    try { history.replaceState(null, "", `#${new URLSearchParams(facts)}`); } catch { /* data: */ }
  }

  // The map.
  const map = byId("map"), over = byId("over");
  const LEFT = 52, BOTTOM = 24, STRIP = 8;

  function colour(share) {
    const at = clamp(share, 0, 1) * (RAMP.length - 1);
    const low = Math.min(Math.floor(at), RAMP.length - 2);
    return RAMP[low].map((value, k) => value + (at - low) * (RAMP[low + 1][k] - value));
  }

  function sized(canvas, width, height) {
    const ratio = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    canvas.style.height = `${height}px`;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    return pen;
  }

  function frame() {
    const width = map.parentElement.clientWidth, high = clamp(lines * 7, 120, 380);
    return {width, high, wide: width - LEFT - STRIP - 4, left: LEFT + STRIP + 2};
  }

  // The largest figure of each cell stays, however many lines and pixels share it.
  function cells(kind, motor, columns, rows) {
    const found = new Float64Array(columns * rows).fill(-1);
    let most = 0;
    for (let line = 1; line <= lines; line++) {
      const values = kind.row(placeOf(line, motor));
      if (!values) continue;
      const gone = kind.key === "speed" ? NaN : lowest(values);
      const base = Math.floor((line - 1) * rows / lines) * columns;
      for (let pixel = 0; pixel < pixels; pixel++) {
        if (values[pixel] === gone) continue;
        const value = Math.abs(values[pixel]), cell = base + Math.floor(pixel * columns / pixels);
        if (value > found[cell]) found[cell] = value;
        if (value > most) most = value;
      }
    }
    return {found, most};
  }

  function drawMap() {
    const {width, high, wide, left} = frame(), kind = MAPS[shown.map];
    const pen = sized(map, width, high + BOTTOM), ratio = window.devicePixelRatio || 1;
    const columns = Math.max(1, Math.min(pixels, Math.round(wide * ratio)));
    const rows = Math.max(1, Math.min(lines, Math.round(high * ratio)));
    const {found, most} = cells(kind, shown.motor, columns, rows);
    const picture = new ImageData(columns, rows);
    found.forEach((value, cell) => {
      const [red, green, blue] = value < 0 ? NO_FIGURE : colour(most ? value / most : 0);
      picture.data.set([red, green, blue, 255], 4 * cell);
    });
    const small = new OffscreenCanvas(columns, rows);
    small.getContext("2d").putImageData(picture, 0, 0);
    pen.imageSmoothingEnabled = false;
    pen.drawImage(small, left, 0, wide, high);
    fates.forEach((fate, at) => {
      const top = at * high / lines, bottom = (at + 1) * high / lines;
      pen.fillStyle = FATES[fate][1];
      pen.fillRect(LEFT, top, STRIP, bottom - top + 0.5);
      if (fate === 0 && kind.key === "speed") {
        pen.fillStyle = "rgba(255, 255, 255, 0.6)";
        pen.fillRect(left, top, wide, bottom - top);
      }
    });
    axes(pen, {high, wide, left});
    byId("low").textContent = "0";
    byId("high").textContent = `${number.format(most)} ${kind.unit}`;
    ramp();
    drawOver();
  }

  function axes(pen, {high, wide, left}) {
    pen.fillStyle = "#51606e";
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const line of ticks(lines, high / 26)) {
      pen.fillText(line, LEFT - 12, clamp((line - 0.5) * high / lines, 7, high - 7));
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const pixel of ticks(pixels, wide / 70)) {
      pen.fillText(pixel, clamp(left + (pixel - 0.5) * wide / pixels, left + 8, left + wide - 12),
        high + 7);
    }
  }

  // Round numbers from 1 to the last one, about as many as there is room for.
  function ticks(last, room) {
    const rough = Math.max(1, last / Math.max(room, 2));
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= rough);
    const found = [1];
    for (let at = step > 1 ? step : 2; at <= last; at += step) found.push(at);
    return found;
  }

  function ramp() {
    const pen = byId("ramp").getContext("2d");
    for (let x = 0; x < 160; x++) {
      pen.fillStyle = `rgb(${colour(x / 159).map(Math.round)})`;
      pen.fillRect(x, 0, 1, 10);
    }
  }

  function drawOver() {
    const {width, high, wide, left} = frame(), pen = sized(over, width, high + BOTTOM);
    const top = (shown.line - 1) * high / lines, tall = Math.max(high / lines, 2);
    pen.strokeStyle = "#e8590c";
    pen.lineWidth = 1.2;
    const from = left + shown.from * wide / pixels, to = left + shown.to * wide / pixels;
    pen.strokeRect(from, top - 1, to - from, tall + 2);
    pen.fillStyle = "#e8590c";
    pen.beginPath();
    pen.moveTo(LEFT - 1, top + tall / 2);
    pen.lineTo(LEFT - 7, top + tall / 2 - 5);
    pen.lineTo(LEFT - 7, top + tall / 2 + 5);
    pen.fill();
  }

  function pointed(event) {
    const {high, wide, left} = frame(), box = map.getBoundingClientRect();
    const pixel = Math.floor((event.clientX - box.left - left) * pixels / wide) + 1;
    const line = Math.floor((event.clientY - box.top) * lines / high) + 1;
    return {line: clamp(line, 1, lines), pixel: clamp(pixel, 1, pixels)};
  }

  map.addEventListener("mousemove", (event) => {
    const {line, pixel} = pointed(event), kind = MAPS[shown.map];
    const values = kind.row(placeOf(line, shown.motor));
    const value = values ? values[pixel - 1] : NaN;
    const there = values && (kind.key === "speed" || value !== lowest(values));
    byId("at").textContent = `line ${line}, pixel ${pixel}: ` +
      (there ? `${number.format(value)} ${kind.unit}` : "no figure") +
      `, ${FATES[fates[line - 1]][0]}`;
  });
  map.addEventListener("mouseleave", () => { byId("at").textContent = HINT; });
  map.addEventListener("click", (event) => choose(pointed(event).line));
  map.addEventListener("keydown", (event) => {
    const step = {ArrowUp: -1, ArrowDown: 1, PageUp: -10, PageDown: 10}[event.key];
    if (step) { choose(shown.line + step); event.preventDefault(); }
  });
  const HINT = "a click chooses a line";

  // The drawings of a line.
  function edges(place, values) {
    if (!values) return null;
    const gone = lowest(values);
    return [null, ...Array.from(values, (value) => (value === gone ? null : value))];
  }

  function positions(place) {
    let at = arrays.start[place];
    return [at, ...Array.from(speeds(place), (steps) => (at += steps))];
  }

  function moved(place, off) {
    if (!off) return null;
    const where = positions(place);
    return edges(place, off).map((value, at) => (value === null ? null : where[at] + value));
  }

  function furthest(off) {
    const there = Array.from(off).filter((value) => value !== lowest(off));
    const most = there.reduce((so, value) => Math.max(so, Math.abs(value)), 0);
    return most ? `at most ${most} step${most === 1 ? "" : "s"} off` : "as expected";
  }

  const NO_RECORDS = "no records of this line (job run --records)";
  const PANES = [
    {name: "Speed", unit: () => "steps/px", stepped: true,
      row: (p) => { const all = speeds(p); return [all[0], ...all]; }},
    {name: "Position", unit: (motor) => motor.unit,
      row: (p, motor) => positions(p).map((steps) => steps / motor.scale)},
    {name: "Edge error", unit: () => "ticks", none: NO_RECORDS,
      row: (p) => edges(p, rowOf("error", "row", p))},
    {name: "Expected", unit: () => "steps", row: positions},
    {name: "Actual", unit: () => "steps", none: NO_RECORDS, off: (p) => rowOf("actual", "row", p),
      row: (p) => moved(p, rowOf("actual", "row", p))},
    {name: "Measured", unit: () => "steps", none: "not measured (job report --measured FILE)",
      off: (p) => rowOf("measured", "measured_row", p),
      row: (p) => moved(p, rowOf("measured", "measured_row", p))},
  ];
  const along = Array.from({length: pixels + 1}, (_, at) => at);
  let zooming = false;

  for (const pane of PANES) {
    const box = document.createElement("div");
    box.className = "pane";
    box.innerHTML = "<h3><div></div><output></output></h3><div></div>";
    byId("panes").append(box);
    pane.title = box.querySelector("h3 div");
    pane.value = box.querySelector("output");
    pane.place = box.lastElementChild;
  }

  function paneSize(pane) {
    return {width: Math.max(pane.place.clientWidth, 100), height: 190};
  }

  function plot(pane, values) {
    if (pane.plot) {
      pane.plot.setData([along, values], false);
      pane.plot.setScale("x", {min: shown.from, max: shown.to});
      return;
    }
    pane.place.textContent = "";
    const font = `12px ${getComputedStyle(document.body).fontFamily}`;
    const axis = {font, stroke: "#51606e", grid: {stroke: "#e8edf1", width: 1},
      ticks: {stroke: "#dde3e9", width: 1}};
    pane.plot = new uPlot({
      ...paneSize(pane),
      scales: {x: {time: false, min: shown.from, max: shown.to}, y: {range: padded}},
      series: [{}, {stroke: "#1767b5", width: 1.5, points: {show: sparse, size: 4},
        paths: pane.stepped ? uPlot.paths.stepped({align: -1}) : uPlot.paths.linear()}],
      axes: [{...axis, size: 34, space: 60}, {...axis, size: 68, space: 34,
        values: (_, all) => all.map((one) => number.format(one))}],
      legend: {show: false},
      cursor: {sync: {key: "line"}, drag: {x: true, y: false, dist: 4}, y: false,
        bind: {dblclick: () => () => { zoom(0, pixels); return null; }}},
      hooks: {drawClear: [band], setCursor: [(u) => tell(pane, u)],
        setScale: [(u, key) => { if (key === "x") zoomed(u); }]},
    }, [along, values], pane.place);
  }

  // Records of every Nth pixel have no neighbours to be joined with: they are dots.
  function sparse(u) {
    const there = u.data[1].filter((value) => value !== null).length;
    return there > 0 && there < pixels / 2;
  }

  function padded(_, low, high) {
    if (low === null || low === undefined) return [-1, 1];
    const pad = low === high ? 1 : 0.06 * (high - low);
    return [low - pad, high + pad];
  }

  function band(u) {
    const first = arrays.image[placeOf(shown.line, shown.motor)];
    if (!first || !image) return;
    const from = Math.max(u.valToPos(first - 1, "x", true), u.bbox.left);
    const end = u.bbox.left + u.bbox.width;
    const to = Math.min(u.valToPos(first - 1 + image, "x", true), end);
    u.ctx.fillStyle = "rgba(23, 103, 181, 0.07)";
    if (to > from) u.ctx.fillRect(from, u.bbox.top, to - from, u.bbox.height);
  }

  function tell(pane, u) {
    const at = u.cursor.idx, value = at === null || at === undefined ? null : u.data[1][at];
    pane.value.textContent = value === null ? pane.said || "" :
      `pixel ${at}: ${number.format(value)} ${pane.unit(motors[shown.motor])}`;
  }

  function zoomed(u) {
    const {min, max} = u.scales.x;
    if (!zooming && min !== null && (min !== shown.from || max !== shown.to)) zoom(min, max);
  }

  function zoom(from, to) {
    const wide = clamp(to - from, Math.min(4, pixels), pixels);
    shown.from = clamp(from, 0, pixels - wide);
    shown.to = shown.from + wide;
    zooming = true;
    for (const {plot: one} of PANES) if (one) one.setScale("x", {min: shown.from, max: shown.to});
    queueMicrotask(() => { zooming = false; });
    drawOver();
    keep();
  }

  function drawLine() {
    const place = placeOf(shown.line, shown.motor), motor = motors[shown.motor];
    for (const pane of PANES) {
      const values = pane.row(place, motor);
      pane.title.innerHTML = `${pane.name} <span>${pane.unit(motor)}</span>`;
      pane.said = values && pane.off ? furthest(pane.off(place)) : "";
      pane.value.textContent = pane.said;
      if (values) { plot(pane, values); continue; }
      if (pane.plot) { pane.plot.destroy(); pane.plot = null; }
      pane.place.innerHTML = `<div class="none">${pane.none}</div>`;
    }
    byId("line").value = shown.line;
    byId("fate").textContent = `${FATES[fates[shown.line - 1]][0]}, motor ${motor.name} ` +
      `(${motor.kind}), ${arrays.sign[place] < 0 ? "backwards" : "forwards"}`;
  }

  function choose(line) {
    shown.line = clamp(Math.round(line) || 1, 1, lines);
    drawLine();
    drawOver();
    keep();
  }

  function choices(where, names, key, draw) {
    names.forEach((name, at) => {
      const button = document.createElement("button");
      button.textContent = name;
      button.setAttribute("aria-pressed", at === shown[key]);
      button.addEventListener("click", () => {
        shown[key] = at;
        [...where.children].forEach((one, k) => one.setAttribute("aria-pressed", k === at));
        draw();
        keep();
      });
      where.append(button);
    });
  }

  function resized() {
    drawMap();
    for (const pane of PANES) if (pane.plot) pane.plot.setSize(paneSize(pane));
  }

  byId("drawings").hidden = false;
  choices(byId("motors"), motors.map(({name}) => name), "motor", () => { drawMap(); drawLine(); });
  choices(byId("kinds"), MAPS.map(({name}) => name), "map", drawMap);
  byId("at").textContent = HINT;
  byId("fates").innerHTML = FATES.filter((_, fate) => fates.includes(fate)).map(
    ([name, shade]) => `<li><i class="dot" style="background:${shade}"></i>${name}</li>`).join("") +
    '<li><i class="dot none"></i>no figure</li>';
  byId("line").max = lines;
  byId("line").addEventListener("change", (event) => choose(Number(event.target.value)));
  byId("before").addEventListener("click", () => choose(shown.line - 1));
  byId("after").addEventListener("click", () => choose(shown.line + 1));
  // Each button: to where the middle goes, and how wide the cut is, both in widths of today's.
  const BUTTONS = [["in", 0, 0.5], ["out", 0, 2], ["left", -0.5, 1], ["right", 0.5, 1]];
  for (const [id, aside, wider] of BUTTONS) {
    byId(id).addEventListener("click", () => {
      const wide = shown.to - shown.from, middle = (shown.from + shown.to) / 2 + aside * wide;
      zoom(middle - wider * wide / 2, middle + wider * wide / 2);
    });
  }
  byId("whole").addEventListener("click", () => zoom(0, pixels));
  drawMap();
  drawLine();
  let width = window.innerWidth;
  window.addEventListener("resize", () => {
    if (window.innerWidth !== width) { width = window.innerWidth; resized(); }
  });
  if (about.reload_s) {
    byId("reload").textContent = `· reloads itself every ${about.reload_s} s`;
    setTimeout(() => location.reload(), 1000 * about.reload_s);
  }
  document.body.dataset.readyMs = Math.round(performance.now());
})();
