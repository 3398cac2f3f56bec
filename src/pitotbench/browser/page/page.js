"use strict";
// The page's own script: files to the server, choices to the server, texts from the server. All that comes is put in as text.

const at = (id) => document.getElementById(id);
let state = null;

function make(tag, text, attributes = {}) {
  const element = document.createElement(tag);
  if (text) element.textContent = text;
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

function say(id, text) {
  const element = at(id);
  if (element.textContent !== text) element.textContent = text;
  if (element.classList.contains("doubt")) element.hidden = !text;
}

function head(names, numbers = []) {
  const row = make("tr");
  row.append(...names.map((name, place) => make("th", name, { scope: "col", class: numbers[place] ? "number" : "" })));
  const top = make("thead");
  top.append(row);
  return top;
}

// The tree of an answer: what each kind of node is on this page. Pictures and files have places of their own.
function table({ head: names, numbers, rows }) {
  const body = make("tbody");
  for (const cells of rows) {
    const row = make("tr");
    row.append(...cells.map((cell, place) => make("td", cell, { class: numbers[place] ? "number" : "" })));
    body.append(row);
  }
  const whole = make("table");
  whole.append(...(rows.length ? [head(names, numbers), body] : []));
  const wide = make("div", "", { class: "scroll" });
  wide.append(whole);
  return wide;
}

function titled(title, inside, folded) {
  const part = make(folded ? "details" : "div");
  part.append(...(title ? [make(folded ? "summary" : "h3", title)] : []), ...inside);
  return part;
}

const KINDS = {
  heading: (node) => titled(node.text, nodes(node.nodes), node.deep),
  sentence: (node) => make("p", node.text),
  doubt: (node) => make("p", node.text, { class: node.first ? "doubt first" : "doubt" }),
  notice: (node) => make("p", node.text),
  table: (node) => titled(node.text, [table(node)], false),
  code: (node) => make("pre", node.text),
  figure: () => "",
};

function nodes(told) {
  const read = told.filter((node) => node.kind === "notice");
  const shown = told.filter((node) => node.kind !== "notice").map((node) => KINDS[node.kind](node));
  return [...shown, ...(read.length ? [titled(`Notes on what was read: ${read.length}`, read.map(KINDS.notice), true)] : [])];
}

// Show nodes in a place, if they are others than it shows.
function tell(id, told) {
  const element = at(id);
  const text = JSON.stringify(told);
  if (element.dataset.told === text) return;
  element.dataset.told = text;
  element.replaceChildren(...nodes(told));
}

async function act(choice) {
  const reply = await fetch("/act", {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(choice),
  }).catch(() => null);
  if (!reply || !reply.ok) {
    say("status", reply ? reply.statusText : "pitotbench has ended: start it again");
    at("working").hidden = false;
  }
}

// Files

async function* filesOf(entry, folder = "") {
  if (entry.isFile) {
    const file = await new Promise((done, failed) => entry.file(done, failed));
    yield [file, folder + file.name];
    return;
  }
  const reader = entry.createReader();
  for (;;) {
    const some = await new Promise((done, failed) => reader.readEntries(done, failed));
    if (!some.length) return;
    for (const each of some) yield* filesOf(each, `${folder}${entry.name}/`);
  }
}

let strangers = 0;

function send(file, name, drop, line) {
  return new Promise((done) => {
    const bar = make("progress", "", { max: file.size || 1, value: 0, "aria-label": name });
    line.replaceChildren(bar, ` ${name}`);
    const request = new XMLHttpRequest();
    request.upload.onprogress = (event) => { bar.value = event.loaded; };
    request.onloadend = () => {
      const whole = request.status === 200;
      if (whole) line.remove();
      else if (request.status === 415 && name.includes("/")) {
        strangers += 1;  // other files of a folder
        line.textContent = `left out: files that are no logs, such as ${name} (${strangers})`;
      } else line.textContent = `${name}: ${request.statusText || "was not taken"}`;
      done(whole);
    };
    request.open("POST", "/upload");
    request.setRequestHeader("X-Name", encodeURIComponent(name));
    request.setRequestHeader("X-Drop", drop);
    request.setRequestHeader("Content-Type", "application/octet-stream");
    request.send(file);
  });
}

async function sendAll(pairs) {
  const drop = Array.from(crypto.getRandomValues(new Uint32Array(3)), (part) => part.toString(36)).join("");
  at("uploads").replaceChildren();
  let arrived = 0;
  strangers = 0;
  for await (const [file, name] of pairs) {
    if (name.split("/").some((part) => part.startsWith("."))) continue;
    const line = make("li");
    at("uploads").append(line);
    const before = strangers;
    if (await send(file, name, drop, line)) arrived += 1;
    if (strangers > before) {
      at("uploads").querySelector(".strange")?.remove();
      line.className = "strange";
    }
  }
  if (arrived) await act({ what: "arrived", drop });
  else if (at("uploads").children.length) await act({ what: "choose", places: [] });
}

const zone = document.documentElement;
for (const kind of ["dragenter", "dragover"]) {
  zone.addEventListener(kind, (event) => { event.preventDefault(); at("drop").classList.add("over"); });
}
zone.addEventListener("dragleave", (event) => { if (!event.relatedTarget) at("drop").classList.remove("over"); });
zone.addEventListener("drop", (event) => {
  event.preventDefault();
  at("drop").classList.remove("over");
  const entries = Array.from(event.dataTransfer.items, (item) => item.webkitGetAsEntry()).filter(Boolean);
  sendAll((async function* () { for (const entry of entries) yield* filesOf(entry); })());
});
for (const id of ["files", "folder"]) {
  at(id).addEventListener("change", () => {
    sendAll(Array.from(at(id).files, (file) => [file, file.webkitRelativePath || file.name]));
    at(id).value = "";
  });
}

// On a narrow screen a long doubt is cut until it is tapped.
at("told").addEventListener("click", (event) => { event.target.closest(".doubt")?.classList.toggle("open"); });

// Choices

// The axis is in minutes, and so is a number alone: 42.5 is 42:30.
function moment(text) {
  const minutes = Number(text.replace(",", "."));
  if (!text.trim() || Number.isNaN(minutes)) return text;
  const seconds = Math.round(60 * minutes);
  return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
}

function flags() {
  const elements = at("flags").elements;
  const told = Object.fromEntries(Object.keys(state.flags).map((name) => [name, elements[name].value]));
  const spans = elements.without.value.split(",").map((span) => span.split("-").map(moment).join("-"));
  act({ what: "flags", flags: { ...told, begin: moment(told.begin), end: moment(told.end) }, without: spans.join(",") });
}

at("flags").addEventListener("submit", (event) => { event.preventDefault(); flags(); });
for (const name of ["model", "parameters", "airspeed_sensor"]) at("flags").elements[name].addEventListener("change", flags);
const look = () => act({ what: "show", unit: at("unit").value, leave_out: document.querySelector("[value=leave]").checked });
at("unit").addEventListener("change", look);
at("whole").addEventListener("click", () => {
  for (const name of ["begin", "end", "without"]) at("flags").elements[name].value = "";
  flags();
});
for (const radio of document.getElementsByName("mode")) {
  radio.addEventListener("change", look);
}
at("all").addEventListener("click", () => {
  for (const box of document.querySelectorAll("#flights input")) box.checked = true;
});
at("choose").addEventListener("click", () => {
  const marked = document.querySelectorAll("#flights input:checked");
  act({ what: "choose", places: Array.from(marked, (box) => Number(box.value)) });
});
at("example").addEventListener("click", () => act({ what: "example" }));
at("map").addEventListener("click", () => {
  const rows = Array.from(document.querySelectorAll("#columns tbody tr"), (row) => {
    const [ours, unit] = row.querySelectorAll("input");
    return [ours.value, unit.value];
  });
  act({ what: "map", rows });
});
for (const button of document.querySelectorAll("[data-copy]")) {
  button.addEventListener("click", async () => {
    await navigator.clipboard.writeText(at(button.dataset.copy).textContent);
    button.textContent = "Copied";
    setTimeout(() => { button.textContent = "Copy"; }, 1500);
  });
}

// Legs

const GROUP = "group (optional)";
const LEG = [GROUP, "KIAS", "pressure altitude [ft]", "air temperature [°C]", "ground speed [kt]", "direction [°]"];

function addLeg() {
  const body = at("typed").querySelector("tbody");
  const row = make("tr");
  const number = body.children.length + 1;
  for (const name of LEG) {
    const cell = make("td");
    cell.append(make("input", "", { size: name === GROUP ? 4 : 7, inputmode: "text", "aria-label": `leg ${number}, ${name}` }));
    row.append(cell);
  }
  body.append(row);
}

at("typed").replaceChildren(head(LEG), make("tbody"));
for (let leg = 0; leg < 3; leg += 1) addLeg();
at("leg").addEventListener("click", addLeg);
const COLUMNS = ["point", "indicated_airspeed_kt", "pressure_altitude_ft", "air_temperature_degc", "ground_speed_kt"];

// 3,000 ft and 3 000 ft are thousands; elsewhere a comma is that of a decimal. A unit behind a number is passed over.
function typed(text, name) {
  const plain = text.replace(/["°]|\s*(kts?|ft|deg|c)\.?\s*$/gi, "").trim();
  const thousands = name.includes("altitude") && /^-?\d{1,3}([,.' \u00a0\u202f]\d{3})+$/.test(plain);
  return thousands ? plain.replace(/[^\d-]/g, "") : plain.replaceAll(",", ".");
}

at("legs").addEventListener("submit", (event) => {
  event.preventDefault();
  const cells = Array.from(at("typed").querySelectorAll("tbody tr"), (row) =>
    Array.from(row.querySelectorAll("input"), (input, place) => typed(input.value, LEG[place])));
  const rows = cells.filter((row) => row.slice(1).some(Boolean));
  const names = [...COLUMNS, at("direction").value];
  // Without airspeeds, ground speeds and tracks alone are asked; without points, these follow from the airspeeds.
  const told = rows.some((row) => row.slice(1, 4).some(Boolean));
  const first = told ? Number(!rows.some((row) => row[0])) : 4;
  const lines = [names, ...rows].map((row) => row.slice(first).join(","));
  act({ what: "legs", card: `${lines.join("\n")}\n` });
});

// Texts

function choices(select, names, chosen) {
  const shown = Object.entries(names);
  if (select.options.length !== shown.length) {
    select.replaceChildren(...shown.map(([value, text]) => make("option", text, { value })));
  }
  select.value = chosen;
}

function same(one, other, ...names) {
  return JSON.stringify(names.map((name) => one[name])) === JSON.stringify(names.map((name) => other[name]));
}

function flights(found, before) {
  if (before && same(before, found, "flights", "chosen", "compared")) return;
  const body = make("tbody");
  found.flights.rows.forEach((cells, place) => {
    const row = make("tr");
    const cell = make("td");
    const box = make("input", "", { type: "checkbox", value: place, "aria-label": `mark ${cells[0]}` });
    box.checked = found.chosen.includes(place);
    const book = found.books[place];
    const shown = book ? found.compared[place] : found.chosen.includes(place);
    const word = book ? "compare" : "show";
    const open = make("button", shown ? { compare: "compared", show: "shown" }[word] : word,
      { type: "button", "aria-label": `${word} ${cells[0]}`, "aria-pressed": shown });
    open.addEventListener("click", () => act(book ? { what: "compare", place } : { what: "choose", places: [place] }));
    const gone = make("button", "remove", { type: "button", "aria-label": `remove ${cells[0]}` });
    gone.addEventListener("click", () => act({ what: "remove", place }));
    cell.append(...(book ? [] : [box, " "]), open, " ", gone);
    row.append(cell);
    const refused = book ? `${cells[0]}: the airspeeds of a handbook, to compare a curve with` : found.refused[place];
    if (refused) row.append(make("td", refused, { colspan: found.flights.head.length }));
    else row.append(...cells.map((text) => make("td", text)));
    row.className = (shown ? "chosen" : "") + (refused && !book ? " refused" : "");
    body.append(row);
  });
  at("flights").replaceChildren(...(found.flights.rows.length ? [head(["", ...found.flights.head]), body] : []));
  at("together").hidden = found.refused.filter((words) => !words).length < 2;
}

function draft(found, before) {
  at("draft").hidden = !found;
  if (!found || (before && JSON.stringify(before) === JSON.stringify(found))) return;
  at("quantities").replaceChildren(...found.ours.map((name) => make("option", "", { value: name })));
  at("units").replaceChildren(...found.units.map((name) => make("option", "", { value: name })));
  const body = make("tbody");
  for (const [theirs, ours, unit, values, question] of found.rows) {
    const row = make("tr");
    const inputs = [["quantities", ours, 22, "ours"], ["units", unit, 7, "unit"]].map(([names, value, size, what]) => {
      const cell = make("td");
      const input = make("input", "", { list: names, size, "aria-label": `${what} for ${theirs}` });
      input.value = value;
      cell.append(input);
      return cell;
    });
    row.append(make("td", theirs), ...inputs, make("td", values), make("td", question));
    body.append(row);
  }
  at("columns").replaceChildren(head(["their column", "ours (empty: not used)", "unit", "first values", "question"]), body);
}

// How long the same has been computed.
let started = 0;
setInterval(() => {
  const seconds = Math.round((Date.now() - started) / 1000);
  say("since", state && state.status && seconds > 1 ? `, ${seconds} s` : "");
}, 500);

const TAKE = { page: "Page (HTML)", card: "Card (CSV)", record: "Record (HTML)", table: "Cockpit table (HTML)", sheet: "Sheet for legs (HTML)", parameters: "Parameters", mapping: "Mapping (TOML)", json: "JSON" };

function show(text) {
  const before = state;
  state = JSON.parse(text);
  const answer = state.answer;
  if (!before || before.status !== state.status) started = Date.now();
  say("status", state.status);
  at("status").classList.toggle("busy", Boolean(state.status));
  at("working").hidden = !state.status;
  const refused = at("refusal").textContent !== state.refusal && state.refusal;
  say("refusal", state.refusal);
  if (refused) at("refusal").scrollIntoView({ block: "nearest" });
  flights(state, before);
  draft(state.draft, before && before.draft);
  const nothing = { kind: "sentence", text: "No log yet. Drop one, or type three legs below." };
  const told = answer ? answer.tree : state.refusal || state.flights.rows.length ? [] : [nothing];
  // What stands before the picture in the tree, and its first doubt, are seen before all pictures.
  const picture = told.findIndex((node) => node.main);
  const early = told.filter((node, place) => picture < 0 || place < picture || node.first);
  if (answer || state.refusal || !state.status) tell("told", early);
  const there = state.command !== "";
  at("flight").hidden = at("way").hidden = !there;
  if (!there) at("more").hidden = at("curve").hidden = true;
  else if (answer || !state.status) at("more").hidden = at("curve").hidden = !answer;
  at("told").classList.toggle("fatal", Boolean(answer && !answer.usable));
  const form = at("flags");
  for (const [name, setting] of Object.entries(state.settings)) {
    if (form.elements[name]) continue;
    const unit = setting.unit ? ` [${setting.unit}]` : "";
    const label = make("label", `${name.replaceAll("_", " ")}${unit} `, { title: setting.help });
    label.append(make("small", setting.flag), " ", make(setting.switch ? "select" : "input", "", { name, size: 10 }));
    at("options").append(label);
    if (setting.switch) choices(form.elements[name], { "": "usual", yes: setting.help }, state.flags[name]);
  }
  const changed = !before || !same(before, state, "flags", "without");
  choices(form.elements.model, Object.fromEntries(state.choices.model.map((n) => [n, n || "usual"])), state.flags.model);
  at("autopilots").replaceChildren(...state.choices.autopilot.map((value) => make("option", "", { value })));
  at("sensor").hidden = !state.several;
  document.querySelector(".key .book").hidden = !state.compared.includes(true);
  choices(at("unit"), state.choices.unit, state.unit);
  for (const radio of document.getElementsByName("mode")) radio.checked = (radio.value === "leave") === state.leave_out;
  if (changed) {
    for (const [name, value] of Object.entries(state.flags)) form.elements[name].value = value;
    form.elements.without.value = state.without.join(", ");
  }
  const course = state.course;
  at("over").hidden = !course;
  tell("course", course ? course.said : []);
  tell("courses", course ? course.table : []);
  at("speeds").replaceChildren(...(course ? course.speeds : []).map((text, place) => make("span", text, { class: `at${place}` })));
  say("command", state.command);
  tell("rest", told.filter((node) => !early.includes(node)));
  at("take").replaceChildren(...(answer ? answer.take : []).map((kind) => make("a", TAKE[kind], { href: `/take/${kind}`, download: "" })));
  const legs = state.legs;
  say("legrefusal", (legs && legs.refusal) || "");
  tell("legsaid", (legs && legs.tree) || []);
  say("legline", (legs && legs.command) || "");
  at("legcommand").hidden = !(legs && legs.command);
  if (legs) at("byhand").open = true;
}

function listen() {
  const found = window.Bokeh && Bokeh.documents.length ? Bokeh.documents[0].get_model_by_name("time") : null;
  if (!found) { setTimeout(listen, 50); return; }
  const hear = () => { if (found.tags.length) show(found.tags[0]); };
  found.properties.tags.change.connect(hear);
  hear();
}
listen();
