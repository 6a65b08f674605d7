"use strict";
// A client in plain JavaScript: it begins a session and frames the session's 3-D page.

const find = (id) => document.getElementById(id);
let robots = [], own = "", reading = null;

function headers(more = {}) {
  const token = find("token") && find("token").value;
  return { "Content-Type": "application/json", ...(token && { Authorization: `Bearer ${token}` }), ...more };
}

class Refused extends Error {
  constructor({ error }) {
    super(error.reason);
    this.kind = error.kind;
  }
}

async function call(method, path, body) {
  const response = await fetch(path, { method, headers: headers(), body: body && JSON.stringify(body) });
  const document = await response.json();
  if (!response.ok) throw new Refused(document);
  return document;
}

function notice(text, bad) {
  find("notice").hidden = !text;
  find("message").textContent = text;
  find("message").className = bad ? "bad" : "";
  find("again").hidden = !bad;
  find("view").hidden = find("window").hidden = Boolean(text);
}

// The page is open as long as this stream of events is read.
async function* events(path, body, signal) {
  const response = await fetch(path, { method: "POST", headers: headers(), body: JSON.stringify(body), signal });
  if (!response.ok) throw new Refused(await response.json());
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    const parts = (text + value).split("\n\n");
    text = parts.pop();
    for (const part of parts) {
      const [, name, data] = /^event: (\w+)\ndata: ([^]*)$/.exec(part) || [];
      if (name) yield [name, JSON.parse(data)];
    }
  }
}

function options(id, names, chosen) {
  find(id).replaceChildren(...names.map((name) => new Option(name, name)));
  find(id).value = chosen;
}

function show({ port, path, group }) {
  find("group").value = group;
  const address = new URL(path, location.origin);
  address.port = port;
  find("view").src = find("window").href = address;
  // No Content-Security-Policy can name an IPv6 address, so its page cannot be framed.
  const framed = !location.hostname.startsWith("[");
  notice(framed ? "" : "Open the 3-D page in a window: it cannot be shown here at an IPv6 address.");
  find("window").hidden = false;
}

async function follow(group, signal) {
  const session = location.hash.slice(1) || own || (await begun(find("robot").value));
  for await (const [name, document] of events(`/sessions/${session}/view`, { group }, signal)) {
    if (name === "feedback" && document.port) show(document);
    if (name === "refusal") throw new Refused(document);
  }
  throw new Error("The server has closed the 3-D page.");
}

// A page of the same session that was closed just now may take a few seconds to end.
async function open(group, tries = 10) {
  if (reading) reading.abort();
  const mine = reading = new AbortController();
  notice("Opening the 3-D page …");
  try {
    await follow(group, mine.signal);
  } catch (error) {
    if (mine.signal.aborted) return;
    if (error.kind !== "busy" || !tries) notice(error.message, true);
    else setTimeout(() => mine.signal.aborted || open(group, tries - 1), 500);
  }
}

async function begun(robot) {
  own = (await call("POST", "/sessions", { robot })).session;
  return own;
}

function end() {
  if (reading) reading.abort();
  if (own) fetch(`/sessions/${own}`, { method: "DELETE", headers: headers(), keepalive: true });
  own = "";
}

function other() {
  end();
  if (location.hash) history.replaceState(null, "", "/");
  groups();
  open("");
}

const groups = () =>
  options("group", Object.keys(robots.find((each) => each.name === find("robot").value).groups), "");

async function start() {
  const known = await fetch("/robots", { headers: headers() });
  find("token-line").hidden = known.status !== 401;
  if (known.status === 401) {
    notice(find("token").value ? "The token is not the server's." : "This server requires its token.");
    return;
  }
  robots = await known.json();
  const session = location.hash && (await call("GET", `/sessions/${location.hash.slice(1)}`));
  options("robot", robots.map((each) => each.name), session ? session.robot : robots[0].name);
  groups();
  await open("");
}

const started = () => start().catch((error) => notice(error.message, true));

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
else {
  find("robot").addEventListener("change", other);
  find("group").addEventListener("change", () => open(find("group").value));
  find("token").addEventListener("change", started);
  find("again").addEventListener("click", () => (robots.length ? open(find("group").value) : started()));
  addEventListener("pagehide", end);
  started();
}
