// SPDX-License-Identifier: MIT
// Shows what `pixstep watch --web` tells: a verdict, boards and their axes, the line as it runs.
"use strict";

(() => {
  const byId = (id) => document.getElementById(id);
  const token = new URLSearchParams(location.search).get("token") || "";
  const ALONE_MS = 3000, SPAN_S = 120, LEAST_S = 20, MOST_PLACES = 2400;
  const FLAGS = {
    clock: ["pixel clock", ""], armed: ["armed", ""], running: ["running", ""],
    permit: ["permit", "warm"], estop: ["emergency stop", "bad"], fault: ["fault", "bad"],
  };
  const boards = new Map(), trails = new Map();
  let place = "", plan = null, said = null, heardMs = performance.now(), speeds = null;

  // Text and elements.
  const whole = new Intl.NumberFormat("en", {maximumFractionDigits: 0});
  const signed = new Intl.NumberFormat(
    "en", {minimumFractionDigits: 1, maximumFractionDigits: 1, signDisplay: "exceptZero"});
  const fixed = (value, digits) => value.toLocaleString(
    "en", {minimumFractionDigits: digits, maximumFractionDigits: digits});
  const figure = (value, digits) => value.toLocaleString(
    "en", {maximumSignificantDigits: digits});
  const since = (seconds) => seconds < 90 ? `${Math.round(seconds)} s`
    : `${Math.round(seconds / 60)} min`;

  function add(parent, tag, name = "", text = "") {
    const made = document.createElement(tag);
    if (name) made.className = name;
    made.textContent = text;
    parent.append(made);
    return made;
  }

  function valued(parent) {
    const box = add(parent, "div");
    return [add(box, "b"), add(box, "span")];
  }

  function say(element, text) { if (element.textContent !== text) element.textContent = text; }

  function colour(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(name);
  }

  function head(tone, text, more = "") {
    byId("head").className = tone;
    say(byId("verdict"), text);
    say(byId("more"), more);
    document.title = `${text} · pixstep`;
  }

  // Drawings.
  function axis(label, more) {
    return {
      stroke: () => colour("--soft"), grid: {stroke: () => colour("--grid"), width: 1},
      ticks: {show: false}, font: `12px ${getComputedStyle(document.body).fontFamily}`,
      label, labelSize: 18, labelGap: 0, labelFont: "12px sans-serif", size: 30, ...more,
    };
  }

  function chart(box, series, x, y, scales) {
    box.replaceChildren();
    const wide = (self, values) => {
      const longest = Math.max(0, ...(values || []).map((one) => one.length));
      return 14 + 7 * longest;
    };
    const made = new uPlot({
      width: box.clientWidth, height: box.clientHeight, legend: {show: false},
      cursor: {drag: {x: false, y: false}}, padding: [10, 12, 0, 0],
      scales: {x: {time: false, ...scales.x}, y: scales.y || {}},
      axes: [axis(x, {}), axis(y, {size: wide})],
      series: [{}, ...series],
    }, series.length === 1 ? [[], []] : [[], ...series.map(() => [])], box);
    new ResizeObserver(() => {
      if (box.clientWidth) made.setSize({width: box.clientWidth, height: box.clientHeight});
    }).observe(box);
    return made;
  }

  const curve = (name, more) => ({
    stroke: () => colour(name), width: 2, points: {show: false}, spanGaps: true, ...more,
  });

  const dots = (name, size) => ({show: true, size, fill: () => colour(name)});

  // A scale that leaves room round values, also round equal ones.
  function roomy(least) {
    return {range: (self, low, high) => {
      if (low === null) return [0, least];
      const room = Math.max(0.06 * (high - low), (least - (high - low)) / 2, 0);
      return [low - room, high + room];
    }};
  }

  // An axis: its figures, and where it was in its line.
  function newPane(parent, tone) {
    const pane = add(parent, "div", "pane");
    pane.style.setProperty("--tone", `var(${tone})`);
    const title = add(pane, "h3"), name = add(title, "b"), beside = add(title, "span");
    const state = add(title, "span", "state");
    const figures = add(pane, "div", "figures");
    const [position, unit] = valued(figures), [speed, rate] = valued(figures);
    const box = add(pane, "div", "chart");
    return {tone, name, beside, state, position, unit, speed, rate, box, drawn: null, key: ""};
  }

  function showAxis(pane, about, trail) {
    say(pane.name, about.motor || `Axis ${about.axis}`);
    say(pane.beside, about.motor ? `axis ${about.axis}` : "");
    say(pane.state, about.state);
    pane.state.className = `state ${about.state}`;
    const steps = `${whole.format(about.position)} steps`;
    say(pane.position, about.unit === "steps" ? whole.format(about.position)
      : fixed(about.position / about.scale, 3));
    say(pane.unit, about.unit === "steps" ? "steps" : `${about.unit} (${steps})`);
    const speed = about.speed === null ? null : about.speed / about.scale;
    say(pane.speed, speed === null ? "" : figure(speed, 4));
    const pixel = about.state === "empty" ? "" : `, pixel ${whole.format(about.pixel)}`;
    say(pane.rate, speed === null ? "" : `${about.unit}/s${pixel}`);
    drawLine(pane, about, trail);
  }

  function drawLine(pane, about, trail) {
    const wanted = (plan && plan.motors[about.motor]) || [];
    if (trail.places.length < 2 && wanted.length < 2) {
      if (!pane.box.firstChild) add(pane.box, "div", "none", "no line yet");
      return;
    }
    if (!pane.drawn) {
      pane.drawn = chart(pane.box, [
        curve("--plan", {width: 6}),
        curve(pane.tone, {width: 1.5, points: dots(pane.tone, 5)}),
        curve(pane.tone, {width: 0, points: dots(pane.tone, 11)}),
      ], "pixel of the line", `position (${about.unit})`, {y: roomy(4 / about.scale), x: roomy(4)});
    }
    const key = `${plan && plan.line} ${trail.line} ${trail.places.length} ${about.position}`;
    if (key === pane.key) return;
    pane.key = key;
    const planned = [wanted.map(([x]) => x), wanted.map(([, y]) => y / about.scale)];
    const made = trail.places.filter(([x], k, all) => !k || x >= all[k - 1][0]);
    const real = [made.map(([x]) => x), made.map(([, y]) => y / about.scale)];
    const last = made.length ? [[real[0].at(-1)], [real[1].at(-1)]] : [[], []];
    pane.drawn.setData(uPlot.join([planned, real, last]));
  }

  // A board.
  function newBoard(key) {
    const section = add(byId("boards"), "section");
    const title = add(section, "h2"), name = add(title, "b"), beside = add(title, "span");
    const flags = add(section, "div", "flags"), cards = add(section, "dl", "cards");
    const made = {section, name, beside, flags: {}, cards: {}, panes: []};
    for (const [flag, [text]] of Object.entries(FLAGS)) {
      made.flags[flag] = add(flags, "span", "", text);
    }
    for (const [card, text] of [
      ["clock", "pixel clock, measured"], ["jitter", "jitter of the clock"], ["fault", "fault"],
      ["bus", "serial line"],
    ]) {
      const box = add(cards, "div");
      add(box, "dt", "", text);
      const value = add(box, "dd");
      made.cards[card] = [add(value, "b"), add(value, "span")];
    }
    made.parent = add(section, "div", "panes");
    made.hint = add(section, "p", "hint");
    boards.set(key, made);
    return made;
  }

  function card(board, name, value, beside, bad = false) {
    const [figures, words] = board.cards[name];
    say(figures, value);
    figures.className = bad ? "bad" : "";
    say(words, beside);
  }

  function showBoard(about) {
    const board = boards.get(about.key) || newBoard(about.key);
    board.section.className = about.stale ? "stale" : "";
    say(board.name, `Board ${about.unit}`);
    const kind = about.kind ? `${about.kind}, firmware ${about.firmware}, ` : "";
    const old = about.stale && about.kind ? `: no figures for ${since(about.age_s)}` : "";
    say(board.beside, `${kind}${about.port}${old}`);
    if (!about.kind) { board.section.className = "stale"; return; }
    for (const [flag, span] of Object.entries(board.flags)) {
      span.className = about.flags[flag] ? `on ${FLAGS[flag][1]}` : "";
    }
    showClock(board, about.clock);
    const fault = about.fault.replaceAll("_", " ");
    card(board, "fault", fault || "none", `switches: ${about.switches}`, Boolean(fault));
    const {per_s: rate, wrong} = about.bus;
    const load = rate == null ? "no rate yet" : "requests a second";
    card(board, "bus", rate == null ? "–" : `${figure(rate, 3)}/s`, wrong || `${load}, no errors`);
    say(board.hint, plan ? "Grey: where the line is to go. Dots: where the axis was at each look."
      : "Dots: where the axis was at each look.");
    about.axes.forEach((one) => {
      const key = `${about.key} ${one.axis}`, trail = follow(key, one, about);
      if (!board.panes[one.axis]) {
        board.panes[one.axis] = newPane(board.parent, `--axis${one.axis % 4}`);
      }
      showAxis(board.panes[one.axis], one, trail);
    });
  }

  function showClock(board, clock) {
    const {measured_hz: measured, set_hz: set, figures, edges} = clock;
    const value = measured == null ? "none" : `${figure(measured, figures ? 7 : 4)} Hz`;
    const off = figures ? `, ${signed.format(figures.offset_ppm)} ppm` : "";
    card(board, "clock", value, `set to ${figure(set, 7)} Hz${off}`);
    const lost = figures && `${whole.format(figures.missing_edges)} missing, `
      + `${whole.format(figures.false_edges)} false edges`;
    card(board, "jitter", figures ? `${fixed(figures.mean_jitter_us, 2)} µs` : "–",
      lost || `${whole.format(edges)} edges since reset`);
  }

  // What was seen of an axis grows here as it does in the program.
  function follow(key, one, about) {
    if (!trails.has(key)) trails.set(key, {line: one.line, places: [], speeds: []});
    const trail = trails.get(key);
    trail.about = one;
    if (trail.line !== one.line) { trail.line = one.line; trail.places = []; }
    const last = trail.places.at(-1);
    if (!last || last[0] !== one.pixel || last[1] !== one.position) {
      trail.places.push([one.pixel, one.position]);
    }
    if (trail.places.length > MOST_PLACES) {
      trail.places = trail.places.filter((_, k) => k % 2 === 0);
    }
    const newest = trail.speeds.at(-1);
    if (one.speed !== null && (!newest || newest[0] < about.time_s)) {
      trail.speeds.push([about.time_s, one.speed]);
    }
    while (trail.speeds.length && trail.speeds[0][0] < about.time_s - SPAN_S) trail.speeds.shift();
    return trail;
  }

  function showSpeeds() {
    const moved = ({about, speeds: all}) => about && all.some(([, speed]) => speed);
    const shown = [...trails].filter(([, one]) => moved(one));
    byId("speeds").hidden = shown.length === 0;
    if (!shown.length) return;
    const units = new Set(shown.map(([, {about}]) => about.unit));
    const common = units.size === 1 ? [...units][0] : "steps";
    const key = shown.map(([name]) => name).join() + common;
    const tone = (about) => `--axis${about.axis % 4}`;
    if (!speeds || speeds.key !== key) {
      const box = document.querySelector("#speeds .chart");
      const drawn = chart(box, shown.map(([, {about}]) => curve(tone(about))), "seconds ago",
        `speed (${common}/s)`, {
          x: {range: (self, low) => [Math.min(low ?? 0, -LEAST_S), 0]},
          y: roomy(common === "steps" ? 2 : 2 / shown[0][1].about.scale),
        });
      speeds = {key, drawn};
      const legend = document.querySelector("#speeds .legend");
      legend.replaceChildren();
      for (const [name, {about}] of shown) {
        const board = boards.size > 1 ? `, board ${name.split(" ").at(-2)}` : "";
        const row = add(legend, "li", "", `${about.motor || `axis ${about.axis}`}${board}`);
        row.style.setProperty("--tone", `var(${tone(about)})`);
      }
    }
    const now = Math.max(...shown.map(([, {speeds: all}]) => all.at(-1)[0]));
    speeds.drawn.setData(uPlot.join(shown.map(([, {about, speeds: all}]) => {
      const scale = common === "steps" ? 1 : about.scale;
      return [all.map(([at]) => at - now), all.map(([, speed]) => speed / scale)];
    })));
  }

  function showRun(run) {
    const share = byId("share");
    share.hidden = !run;
    if (run) share.value = run.lines ? run.printed / run.lines : 0;
    const line = run && plan ? `, line ${plan.line} of ${run.lines} drawn below` : "";
    say(byId("place"), `${place}${line}`);
  }

  function heard() {
    heardMs = performance.now();
    document.body.classList.remove("alone");
  }

  // A page that hears nothing says so: old figures must not look like new ones.
  setInterval(() => {
    const silentMs = performance.now() - heardMs;
    if (silentMs < ALONE_MS) return;
    document.body.classList.add("alone");
    head("red", `No connection to pixstep for ${since(silentMs / 1000)}`,
      "Everything below is as it was then. The page connects again by itself.");
  }, 500);

  const source = new EventSource(`events?token=${encodeURIComponent(token)}`);
  source.addEventListener("past", (event) => {
    heard();
    const past = JSON.parse(event.data);
    place = past.place;
    byId("stop").hidden = !past.stops;
    boards.clear();
    trails.clear();
    speeds = null;
    byId("boards").replaceChildren();
    for (const [key, trail] of Object.entries(past.trails)) trails.set(key, trail);
  });
  source.addEventListener("plan", (event) => { plan = JSON.parse(event.data); });
  source.addEventListener("look", (event) => {
    heard();
    const look = JSON.parse(event.data);
    head(look.verdict.colour, look.verdict.text, look.verdict.more);
    const notes = look.notes.map(
      ({colour: tone, text, more}) => [tone, more ? `${text}: ${more}` : text]);
    if (said) notes.push(said);
    const now = JSON.stringify(notes);
    if (byId("notes").dataset.now !== now) {
      byId("notes").dataset.now = now;
      byId("notes").replaceChildren();
      for (const [tone, text] of notes) add(byId("notes"), "li", tone, text);
    }
    look.boards.forEach(showBoard);
    showRun(look.run);
    showSpeeds();
    const known = look.boards.every((one) => one.kind || one.trouble);
    if (known && !document.body.dataset.readyMs) {
      requestAnimationFrame(() => {
        document.body.dataset.readyMs = performance.now().toFixed(0);
      });
    }
  });

  byId("stop").addEventListener("click", async () => {
    let text = "NOT STOPPED as far as is known: pixstep does not answer", tone = "red";
    try {
      const reply = await fetch(`stop?token=${encodeURIComponent(token)}`, {method: "POST"});
      text = (await reply.text()).trim();
      tone = reply.ok && !text.includes("NOT STOPPED") ? "green" : "red";
    } catch { /* the text says it */ }
    said = [tone, `${new Date().toLocaleTimeString("en-GB")} ${text}`];
  });
})();
