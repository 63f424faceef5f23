"use strict";
(() => {
  const STEP = Math.PI / 8, CLOSER = 0.8, ROOM = 1.04, FIELD = Math.PI / 4; // of view, from top to bottom
  const page = document.documentElement, view = document.getElementById("view");
  const read = (id) => JSON.parse(document.getElementById(id).textContent);

  const stillOnly = () => {
    page.classList.remove("live");
    document.querySelector(".no-webgl").hidden = false;
    view.dataset.state = "still";
  };
  const drawable = () => {
    try {
      const canvas = document.createElement("canvas");
      return Boolean(canvas.getContext("webgl2") || canvas.getContext("webgl"));
    } catch {
      return false;
    }
  };
  if (!drawable()) {
    stillOnly();
    return;
  }

  // The page is shown before it is drawn, because the view must know its own size.
  page.classList.add("live");
  const start = read("start"), figure = read("figure");
  const distance = () => {
    const field = Math.tan(FIELD / 2) * (view.clientWidth / Math.max(view.clientHeight, 1));
    const wide = start.nearest.map((near, step) => near + ((step + 1) * start.step) / field);
    return ROOM * Math.max(start.tall, ...wide);
  };
  const standing = (back, far) => ({
    up: {x: 0, y: 0, z: 1}, center: {x: 0, y: 0, z: 0},
    eye: {x: back[0] * far, y: back[1] * far, z: back[2] * far},
  });
  const turned = (eye, angle) => {
    const cosine = Math.cos(angle), sine = Math.sin(angle);
    return {x: cosine * eye.x - sine * eye.y, y: sine * eye.x + cosine * eye.y, z: eye.z};
  };
  const scaled = (eye, factor) => ({x: eye.x * factor, y: eye.y * factor, z: eye.z * factor});
  const moves = {
    start: () => standing(start.back, distance()),
    other: () => standing(start.other, distance()),
    left: (now) => ({...now, eye: turned(now.eye, STEP)}),
    right: (now) => ({...now, eye: turned(now.eye, -STEP)}),
    closer: (now) => ({...now, eye: scaled(now.eye, CLOSER)}),
    farther: (now) => ({...now, eye: scaled(now.eye, 1 / CLOSER)}),
  };
  const seen = () => view._fullLayout.scene._scene.getCamera();
  const wire = () => {
    for (const button of document.querySelectorAll("button[data-move]")) {
      button.addEventListener("click", () =>
        Plotly.relayout(view, {"scene.camera": moves[button.dataset.move](seen())}));
    }
    for (const box of document.querySelectorAll("input[data-traces]")) {
      const traces = JSON.parse(box.dataset.traces);
      const set = () => Plotly.restyle(view, {visible: box.checked}, traces);
      box.addEventListener("change", set);
      if (box.checked !== box.defaultChecked) set(); // a browser that remembers the form
    }
    view.addEventListener("webglcontextlost", stillOnly, true);
    view.dataset.state = "ready";
  };
  figure.layout.scene.camera = standing(start.back, distance());
  const options = {displayModeBar: false, displaylogo: false, responsive: true};
  Plotly.newPlot(view, figure.data, figure.layout, options).then(wire).catch(stillOnly);
})();
