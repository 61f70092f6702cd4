"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const get = (id) => document.getElementById(id);
  const reduced = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const SPACE = "http://www.w3.org/2000/svg";
  let at = 0;
  let timer = 0;

  // Texts go in as text, never as markup.
  function element(name, text = "", kind = "") {
    const made = document.createElement(name);
    made.textContent = text;
    if (kind) made.className = kind;
    return made;
  }

  function drawn(name, attributes) {
    const made = document.createElementNS(SPACE, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return made;
  }

  function dot(color) {
    const svg = drawn("svg", { viewBox: "0 0 12 12", class: "dot", "aria-hidden": "true" });
    svg.append(drawn("circle", { cx: 6, cy: 6, r: 6, fill: color }));
    return svg;
  }

  function showDecision(step) {
    get("headline").replaceChildren(dot(data.colors[step.a]), element("span", data.actions[step.a]));
    get("reason").textContent = step.s;
    get("marks").replaceChildren(...step.k.map((mark) => element("span", mark)));
    const items = step.p.map(([option, distance, gaps], i) => {
      const item = element("li");
      const row = element("div", "", "row");
      row.append(element("b", `${i ? "option" : "root"} ${option}`), element("span", `distance ${distance}`, "dim num"));
      item.append(row, ...gaps.map((gap) => element("div", gap, "gap")));
      return item;
    });
    items.push(element("li", data.actions[step.a], "end"));
    get("path").replaceChildren(...items);
    const low = Math.min(...step.n);
    const high = Math.max(...step.n);
    const rows = step.v.map((value, i) => {
      const row = element("tr", "", i === step.a ? "chosen" : "");
      const name = element("th", data.actions[i]);
      name.scope = "row";
      const cell = element("td", "", "bar");
      const bar = element("div");
      // Bars compare the actions: the worst still shows a little, the best fills the row.
      bar.style.width = `${high === low ? 100 : 8 + (92 * (step.n[i] - low)) / (high - low)}%`;
      bar.style.color = data.colors[i];
      cell.append(bar);
      row.append(name, cell, element("td", value, "num"));
      return row;
    });
    get("actions").tBodies[0].replaceChildren(...rows);
    get("vote").hidden = step.w.length < 2;
    const voters = step.w.map(([option, share, preferred]) => {
      const row = element("tr");
      const name = element("th", `option ${option}`);
      name.scope = "row";
      const prefers = element("td");
      prefers.append(dot(data.colors[preferred]), ` ${data.actions[preferred]}`);
      row.append(name, prefers, element("td", share, "num"));
      return row;
    });
    get("voters").tBodies[0].replaceChildren(...voters);
    const seen = step.o.map((value, i) => {
      const row = element("tr");
      const name = element("th", data.features[i]);
      name.scope = "row";
      row.append(name, element("td", value, "num"));
      return row;
    });
    get("seen").tBodies[0].replaceChildren(...seen);
  }

  function showPath(step) {
    const places = step.p.map(([option]) => [option, data.places[option]]).filter(([, place]) => place);
    const parts = [];
    // As big on the screen whatever the width of the window.
    const svg = get("forest-path").ownerSVGElement;
    const unit = svg.viewBox.baseVal.width / (svg.getBoundingClientRect().width || 1000);
    const ring = Math.max(data.ring, 5 * unit);
    if (places.length) {
      const points = places.map(([, place]) => place.join(",")).join(" ");
      parts.push(drawn("polyline", { points, class: "way", "stroke-width": 2.5 * unit }));
    }
    for (const [i, [option, [x, y]]] of places.entries()) {
      parts.push(drawn("circle", { cx: x, cy: y, r: ring, class: "way", "stroke-width": 2 * unit }));
      if (i === 0 || i === places.length - 1) {
        // On the side that leads away from the other end, so that the two stay apart.
        const goesRight = places.at(-1)[1][0] >= places[0][1][0];
        const isRight = places.length === 1 || (i === 0) !== goesRight;
        const away = ring + 3 * unit;
        const name = drawn("text", {
          x: isRight ? x + away : x - away, y: y - ring, class: "way-name",
          "font-size": 15 * unit, "text-anchor": isRight ? "start" : "end",
        });
        name.textContent = option;
        parts.push(name);
      }
    }
    get("forest-path").replaceChildren(...parts);
  }

  function show(step) {
    at = Math.max(0, Math.min(data.steps.length - 1, step));
    const shown = data.steps[at];
    showDecision(shown);
    showPath(shown);
    get("slider").value = at;
    get("slider").setAttribute("aria-valuetext", `step ${at}: ${data.actions[shown.a]}`);
    get("position").textContent = `step ${at} of ${data.steps.length - 1}`;
    const x = data.chart.left + (data.chart.width * at) / Math.max(1, data.steps.length - 1);
    get("cursor").setAttribute("x1", x);
    get("cursor").setAttribute("x2", x);
    for (const [id, off] of [["first", at === 0], ["back", at === 0], ["next", at === data.steps.length - 1], ["last", at === data.steps.length - 1]]) {
      get(id).setAttribute("aria-disabled", off);
    }
  }

  function play(on) {
    clearInterval(timer);
    timer = on ? setInterval(() => (at === data.steps.length - 1 ? play(false) : show(at + 1)), reduced ? 1000 : 200) : 0;
    get("play").textContent = on ? "❚❚ Pause" : "▶ Play";
    get("play").setAttribute("aria-label", on ? "Pause" : "Play");
    get("play").setAttribute("aria-pressed", on);
  }

  function go(step) {
    play(false);
    show(step);
  }

  get("first").onclick = () => go(0);
  get("back").onclick = () => go(at - 1);
  get("next").onclick = () => go(at + 1);
  get("last").onclick = () => go(data.steps.length - 1);
  get("slider").oninput = () => go(Number(get("slider").value));
  get("play").onclick = () => {
    if (!timer && at === data.steps.length - 1) show(0);
    play(!timer);
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const moves = {
      ArrowLeft: at - 1, ArrowRight: at + 1, PageUp: at - 10, PageDown: at + 10, Home: 0, End: data.steps.length - 1,
    };
    const onControl = event.target.closest("button, summary, a");
    if (event.key in moves) go(moves[event.key]);
    else if (event.key === " " && !onControl) get("play").click();
    else return;
    event.preventDefault();
  });
  get("margins").addEventListener("click", (event) => {
    const svg = get("margins").querySelector("svg");
    const box = svg.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * svg.viewBox.baseVal.width;
    go(Math.round(((x - data.chart.left) / data.chart.width) * (data.steps.length - 1)));
  });
  addEventListener("resize", () => show(at));
  show(0);
})();
