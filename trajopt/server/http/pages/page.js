"use strict";
// A client in plain JavaScript: it asks as any other client does, and needs nothing but this server.

const find = (id) => document.getElementById(id);
const COLOURS = ["#0f766e", "#b45309", "#4f46e5", "#be123c", "#0369a1", "#65a30d", "#7c3aed", "#475569"];
let robots = [], session = null, answer = null, places = null, running = null;

function headers(more = {}) {
  const token = find("token") && find("token").value;
  return token ? { Authorization: `Bearer ${token}`, ...more } : more;
}

async function call(method, path, body) {
  const response = await fetch(path, {
    method, headers: headers({ "Content-Type": "application/json" }),
    body: method === "POST" ? JSON.stringify(body || {}) : undefined,
  });
  const document = await response.json();
  if (!response.ok) throw new Error(`${document.error.kind}: ${document.error.reason}`);
  return document;
}

// Ask with feedback: server-sent events, read from the body of the answer.
async function ask(path, body, told) {
  running = new AbortController();
  const response = await fetch(path, {
    method: "POST", signal: running.signal, body: JSON.stringify(body),
    headers: headers({ "Content-Type": "application/json", Accept: "text/event-stream" }),
  });
  if (!response.ok) {
    const { error } = await response.json();
    throw new Error(`${error.kind}: ${error.reason}`);
  }
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) throw new Error("the server has gone");
    text += value;
    const events = text.split("\n\n");
    text = events.pop();
    for (const event of events) {
      const parts = /^event: (\w+)\ndata: ([^]*)$/.exec(event);
      if (!parts) continue;
      const document = JSON.parse(parts[2]);
      if (parts[1] === "feedback") told(document);
      if (parts[1] === "answer") return document;
      if (parts[1] === "refusal") throw new Error(`${document.error.kind}: ${document.error.reason}`);
    }
  }
}

const robot = () => robots.find((each) => each.name === find("robot").value);
const joints = () => robot().groups[find("group").value];

function sliders(id, positions) {
  const box = find(id);
  box.replaceChildren();
  for (const joint of joints()) {
    const { lower, upper } = robot().joints[joint];
    const line = document.createElement("div"), name = document.createElement("span");
    const slider = document.createElement("input"), shown = document.createElement("output");
    line.className = "joint";
    name.textContent = name.title = joint;
    Object.assign(slider, { type: "range", min: lower ?? -3.14, max: upper ?? 3.14, step: 0.001 });
    slider.value = positions[joint] ?? 0;
    slider.dataset.joint = joint;
    slider.setAttribute("aria-label", `${id} ${joint}`);
    const show = () => { shown.textContent = Number(slider.value).toFixed(3); };
    slider.addEventListener("input", show);
    show();
    line.append(name, slider, shown);
    box.append(line);
  }
}

const positionsOf = (id) =>
  Object.fromEntries([...find(id).querySelectorAll("input")].map((each) => [each.dataset.joint, Number(each.value)]));

function chosen() {
  const states = robot().states.filter((each) => each.group === find("group").value);
  const first = states.length ? states[0].positions : {};
  const start = (states.find((each) => each.name === "ready") || { positions: first }).positions;
  sliders("start", start);
  const goal = { ...start };
  const turned = joints()[0], { lower, upper } = robot().joints[turned];
  goal[turned] = Math.min(Math.max((start[turned] ?? 0) + 0.9, lower ?? -3), upper ?? 3);
  sliders("start", { ...start, [turned]: Math.max((start[turned] ?? 0) - 0.9, lower ?? -3) });
  sliders("goal", goal);
}

const numbers = (id) => find(id).value.split(",").map(Number);

function edits() {
  if (!find("with-box").checked) return [];
  const [x, y, z] = numbers("edges");
  return [{ add: { name: "box", shape: { box: { x, y, z } }, placement: { xyz: numbers("centre") } } }];
}

function problem() {
  return {
    edits: edits(),
    problem: {
      group: find("group").value,
      start: positionsOf("start"),
      goal: { joint_positions: { positions: positionsOf("goal") } },
    },
  };
}

async function begin() {
  if (!session) session = await call("POST", "/sessions", { robot: find("robot").value });
  return `/sessions/${session.session}`;
}

function busy(now) {
  find("plan").disabled = now;
  find("cancel").disabled = !now;
  find("execute").disabled = now || !answer || !answer.verified;
}

function say(text, bad) {
  find("verdict").textContent = text;
  find("verdict").className = bad ? "bad" : "";
}

async function plan() {
  busy(true);
  try {
    const at = await begin();
    answer = await ask(`${at}/plan`, { ...problem(), certificate: true }, (told) => {
      const best = told.best === null ? "" : `, have ${told.best.toFixed(3)} s`;
      find("feedback").textContent = `${told.stage}, attempt ${told.attempt}${best}`;
    });
    find("feedback").textContent = "";
    if (!answer.points.length) {
      say(answer.message, true);
      return;
    }
    const about = answer.verified ? `Proven: ${answer.duration.toFixed(3)} s` : answer.message;
    const clearance = answer.certificate && answer.certificate.clearance;
    say(about + (clearance ? `, nearest ${(1000 * clearance).toFixed(1)} mm` : ""), !answer.verified);
    const kept = thinned(answer.points, 120);
    places = await call("POST", `${at}/forward_kinematics`, {
      group: find("group").value, start: positionsOf("start"), positions: kept.map((each) => each.positions),
    });
    find("time").disabled = false;
    find("time").value = 1000;
    draw();
  } catch (error) {
    say(error.message, true);
  } finally {
    busy(false);
  }
}

async function drive() {
  busy(true);
  try {
    const at = await begin();
    const done = await ask(`${at}/execute`, { ...problem(), speed: 1 }, (told) => {
      find("feedback").textContent = `driving, ${told.time.toFixed(1)} s`;
      const share = Math.min(told.time / answer.duration, 1);
      find("time").value = 1000 * share;
      draw();
    });
    find("feedback").textContent = done.reached ? `reached after ${done.duration.toFixed(2)} s` : "stopped";
  } catch (error) {
    find("feedback").textContent = error.message;
  } finally {
    busy(false);
  }
}

async function cancel() {
  if (session) await call("POST", `/sessions/${session.session}/stop`);
  if (running) running.abort();
}

function thinned(points, most) {
  const step = Math.max(1, Math.ceil(points.length / most));
  return points.filter((_, i) => i % step === 0 || i === points.length - 1);
}

// A view from the front and the right, x towards the reader's lower left.
function projected([x, y, z], canvas) {
  const scale = canvas.height / 1.35;
  return [canvas.width / 2 + scale * (0.87 * y - 0.42 * x), canvas.height * 0.8 - scale * (z - 0.2 * x - 0.12 * y)];
}

function boxEdges() {
  const [cx, cy, cz] = numbers("centre"), [dx, dy, dz] = numbers("edges").map((each) => each / 2);
  const corners = [];
  for (const i of [-1, 1]) for (const j of [-1, 1]) for (const k of [-1, 1]) corners.push([cx + i * dx, cy + j * dy, cz + k * dz]);
  const edges = [];
  corners.forEach((a, i) => corners.forEach((b, j) => {
    if (i < j && a.filter((value, k) => value !== b[k]).length === 1) edges.push([a, b]);
  }));
  return edges;
}

function line(context, points, colour, width) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.stroke();
}

function draw() {
  const canvas = find("view"), context = canvas.getContext("2d");
  context.clearRect(0, 0, canvas.width, canvas.height);
  const floor = [-0.8, -0.4, 0, 0.4, 0.8];
  for (const at of floor) {
    line(context, [[at, -0.8, 0], [at, 0.8, 0]].map((each) => projected(each, canvas)), "#e5eaf0", 1);
    line(context, [[-0.8, at, 0], [0.8, at, 0]].map((each) => projected(each, canvas)), "#e5eaf0", 1);
  }
  if (find("with-box").checked) {
    for (const edge of boxEdges()) line(context, edge.map((each) => projected(each, canvas)), "#b45309", 1.5);
  }
  if (!places) return;
  const links = Object.values(places.placements), count = links[0].length;
  const share = find("time").value / 1000, now = Math.round(share * (count - 1));
  const arm = (i) => links.map((each) => projected(each[i].xyz, canvas));
  for (let i = 0; i < count; i += Math.max(1, Math.floor(count / 8))) line(context, arm(i), "#cfd8e3", 1.5);
  const tips = Array.from({ length: count }, (_, i) => arm(i)[links.length - 1]);
  line(context, tips, "#0f766e88", 2);
  line(context, arm(now), "#1d2733", 4);
  context.fillStyle = "#0f766e";
  for (const [x, y] of arm(now)) {
    context.beginPath();
    context.arc(x, y, 4, 0, 7);
    context.fill();
  }
  curves(share);
}

function curves(share) {
  const canvas = find("curves"), context = canvas.getContext("2d"), edge = 30;
  context.clearRect(0, 0, canvas.width, canvas.height);
  const all = answer.points.flatMap((each) => each.positions);
  const low = Math.min(...all), high = Math.max(...all), last = answer.duration;
  const x = (time) => edge + (canvas.width - 2 * edge) * time / last;
  const y = (value) => canvas.height - edge - (canvas.height - 2 * edge) * (value - low) / (high - low || 1);
  context.font = "12px system-ui";
  context.fillStyle = "#64748b";
  context.fillText(`${high.toFixed(2)} rad`, 4, edge - 10);
  context.fillText(`${low.toFixed(2)}`, 4, canvas.height - edge + 14);
  context.fillText(`${last.toFixed(2)} s`, canvas.width - 2 * edge, canvas.height - 8);
  answer.joint_names.forEach((_, joint) => {
    const points = answer.points.map((each) => [x(each.time_from_start), y(each.positions[joint])]);
    line(context, points, COLOURS[joint % COLOURS.length], 2);
  });
  line(context, [[x(share * last), edge / 2], [x(share * last), canvas.height - edge]], "#1d273366", 1);
  find("legend").replaceChildren(...answer.joint_names.map((name, joint) => {
    const shown = document.createElement("b");
    shown.style.setProperty("color", COLOURS[joint % COLOURS.length]);
    shown.textContent = `${name} `;
    return shown;
  }));
}

function options(id, names) {
  find(id).replaceChildren(...names.map((name) => new Option(name, name)));
}

async function start() {
  const health = await (await fetch("/health")).json();
  find("health").textContent = `${health.workers} worker${health.workers === 1 ? "" : "s"}`;
  const known = await fetch("/robots", { headers: headers() });
  if (known.status === 401) {
    find("token-line").hidden = false;
    find("token").addEventListener("change", start, { once: true });
    say("This server asks for a token.", true);
    return;
  }
  robots = await known.json();
  options("robot", robots.map((each) => each.name));
  const groups = () => {
    session = answer = places = null;
    options("group", Object.keys(robot().groups));
    const largest = Object.entries(robot().groups).sort((a, b) => b[1].length - a[1].length);
    const arm = largest.find(([name]) => robot().states.some((each) => each.group === name)) || largest[0];
    find("group").value = arm[0];
    chosen();
    draw();
  };
  find("robot").addEventListener("change", groups);
  find("group").addEventListener("change", chosen);
  find("time").addEventListener("input", draw);
  for (const id of ["with-box", "centre", "edges"]) find(id).addEventListener("change", draw);
  find("plan").addEventListener("click", plan);
  find("execute").addEventListener("click", drive);
  find("cancel").addEventListener("click", cancel);
  groups();
}

async function docs() {
  const { paths } = await (await fetch("/openapi.json", { headers: headers() })).json();
  for (const [path, methods] of Object.entries(paths)) {
    for (const [method, about] of Object.entries(methods)) {
      const article = document.createElement("article"), code = document.createElement("code");
      const words = document.createElement("p");
      code.textContent = `${method.toUpperCase()} ${path}`;
      words.textContent = about.description;
      article.append(code, words);
      find("paths").append(article);
    }
  }
}

if (document.body.dataset.page === "docs") docs();
else start().catch((error) => say(error.message, true));
