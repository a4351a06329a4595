// The console renders the pages. This script sends the buttons' requests, and updates parts of a
// page when the console reports a change.
"use strict";

const said = document.getElementById("said");
const sure = document.getElementById("sure");
const title = document.title;
const PAUSE_MS = 400; // typed text is checked after a pause of this length
const FOCUSABLE = "button, a, select, input:not([type=hidden])";
const MOST_UNDONE = 20; // changes of a study
const AGAIN_MS = 2000; // the browser does not retry a rejected stream
let state = document.getElementById("state").dataset.state;

let passing = []; // kinds of the jobs that the shown sentence is about

function say(sentence, bad = false) {
  said.textContent = sentence;
  said.classList.toggle("bad", bad);
}

async function request(path, fields) {
  const answer = await fetch(path, {
    method: "POST",
    headers: { "content-type": "application/json", "x-slipscale": "1" },
    body: JSON.stringify(fields),
  }).catch(() => null);
  const told = answer ? await answer.json().catch(() => ({ said: "?" })) : { said: document.body.dataset.lost };
  return { good: Boolean(answer && answer.ok), ...told };
}

// What an action said before it led to this page.
say(sessionStorage.getItem("slipscale-said") || "");
sessionStorage.removeItem("slipscale-said");

const post = (action, fields) => request(`/do/${action}`, fields);

async function ask(action, fields) {
  const { good, said: sentence, started = [] } = await post(action, fields);
  say(sentence, !good);
  passing = started;
  await refresh();
  return good;
}

// A sentence about a job that has been started lasts as long as the job; then its card says more.
function pass() {
  const running = document.getElementById("state").dataset.jobs.split(" ");
  if (!passing.length || passing.some((kind) => running.includes(kind))) return;
  passing = [];
  say("");
}

// Asks for confirmation, and for words or a choice if needed.
function confirmed(button) {
  const { question, ask: wanted, choices } = button.dataset;
  if (!question) return Promise.resolve({});
  document.getElementById("sure-question").textContent = question;
  const words = document.getElementById("sure-words");
  const choice = document.getElementById("sure-choice");
  const input = words.querySelector("input");
  const select = choice.querySelector("select");
  words.hidden = !["reason", "optional", "word"].includes(wanted);
  choice.hidden = wanted !== "question";
  input.value = "";
  input.required = wanted === "reason" || wanted === "word";
  select.replaceChildren(...JSON.parse(choices || "[]").map((name) => new Option(name, name)));
  sure.querySelector(".main").textContent = button.textContent;
  sure.returnValue = "no";
  sure.showModal();
  return new Promise((resolve) => {
    sure.addEventListener("close", () => {
      if (sure.returnValue !== "yes") return resolve(null);
      if (wanted === "question") return resolve({ question: select.value });
      if (wanted === "word") return resolve({ word: input.value });
      return resolve(words.hidden ? {} : { reason: input.value });
    }, { once: true });
  });
}

// Enter in the dialog means yes, not the first button.
sure.addEventListener("keydown", (event) => {
  if (event.key === "Enter" && event.target.tagName === "INPUT") {
    event.preventDefault();
    sure.querySelector(".main").click();
  }
});

document.addEventListener("click", async (event) => {
  const opener = event.target.closest("[data-open]");
  if (opener) return document.getElementById(opener.dataset.open).showModal();
  const button = event.target.closest("[data-do]");
  if (!button || sure.open) return;
  const { from } = button.dataset;
  if (from) button.dataset.fields = JSON.stringify({ [from]: button.form.elements[from].value });
  const more = await confirmed(button);
  if (more) await ask(button.dataset.do, { ...JSON.parse(button.dataset.fields), ...more });
});

// A text on a picture of a screen leads to its form.
document.addEventListener("click", (event) => {
  const text = event.target.closest("[data-text]");
  const link = text && text.closest("figure").querySelector(`a[href*="key=${CSS.escape(text.dataset.text)}&"]`);
  if (!link) return;
  event.preventDefault();
  location.assign(link.href);
});

// What a filter or slider chooses is a part of the address, so that every renewal keeps it.
let choosing = 0;
document.addEventListener("input", ({ target }) => {
  const form = target.closest("[data-filter]");
  if (!form) return;
  const values = target.dataset.values && JSON.parse(target.dataset.values);
  if (values) target.previousElementSibling.textContent = values[Number(target.value)];
  clearTimeout(choosing);
  choosing = setTimeout(() => {
    const chosen = [...new FormData(form)].filter(([, value]) => value);
    history.replaceState(null, "", `?${new URLSearchParams(chosen)}`);
    refresh();
  }, PAUSE_MS / 2);
});

// Somebody may type before this script runs.
for (const input of document.querySelectorAll("[data-filter] textarea")) {
  if (input.value !== input.defaultValue) input.dispatchEvent(new Event("input", { bubbles: true }));
}

// A file's content is its text in base64.
function contentOf(file) {
  const reader = new FileReader();
  reader.readAsDataURL(file);
  return new Promise((resolve) => {
    reader.onload = () => resolve({ name: file.name, content: reader.result.split(",")[1] || "" });
    reader.onerror = () => resolve({ name: file.name, content: "" });
  });
}

function valueOf(input) {
  if (input.type === "file") return Promise.all([...input.files].map(contentOf));
  if (input.type === "checkbox") return input.checked;
  return input.type === "number" ? Number(input.value) : input.value;
}

document.addEventListener("submit", async (event) => {
  if (event.target.matches("[data-filter]")) event.preventDefault();
  const form = event.target.closest("[data-form]");
  if (!form) return;
  event.preventDefault();
  const inputs = [...form.elements].filter((input) => input.name && !("skip" in input.dataset));
  const sizeOf = (input) => [...(input.files ?? [])].reduce((sum, file) => sum + file.size, 0);
  const large = inputs.find((input) => sizeOf(input) > Number(input.dataset.most));
  if (large) return say(large.dataset.tooLarge, true);
  const fields = {};
  for (const input of inputs) {
    const { of } = input.dataset;
    // Names can be those of a table's columns, such as "__proto__".
    Object.defineProperty(of ? (fields[of] ??= {}) : fields, input.name, { value: await valueOf(input), enumerable: true });
  }
  if ("once" in form.dataset) form.reset();
  if (!form.dataset.more) {
    const good = await ask(event.submitter?.value || form.dataset.form, fields);
    if (good && form.dataset.to) {
      sessionStorage.setItem("slipscale-said", said.textContent);
      location.assign(form.dataset.to);
    }
    return;
  }
  const { good, said: sentence } = await post(form.dataset.form, { [form.id]: fields, ...JSON.parse(form.dataset.more) });
  if (good) return location.reload();
  say(sentence, true);
  for (const input of inputs) input.setAttribute("aria-invalid", new RegExp(`\\b${input.name}\\b`).test(sentence));
  form.querySelector("[aria-invalid=true]")?.focus();
});

document.addEventListener("keydown", (event) => {
  const typing = event.target.closest("input, textarea, select, dialog");
  if (typing || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
  const button = document.querySelector(`[data-key="${CSS.escape(event.key)}"]`);
  if (!button) return;
  event.preventDefault(); // otherwise the letter would be typed into the dialog that opens
  button.click();
});

// Updates ---------------------------------------------------------------------------------------

async function refresh() {
  // A console that is stopped while it answers breaks off the page's text.
  const page = await fetch(location.href, { headers: { accept: "text/html" } })
    .then((answer) => (answer.ok ? answer.text() : null)).catch(() => null);
  if (page === null) return;
  const fresh = new DOMParser().parseFromString(page, "text/html");
  if (fresh.body.dataset.console !== document.body.dataset.console) return location.reload();
  for (const part of document.querySelectorAll("[data-live]")) {
    const other = fresh.getElementById(part.id);
    for (const each of part.querySelectorAll("details[open]")) fresh.getElementById(each.id)?.setAttribute("open", "");
    if (!other || other.outerHTML === part.outerHTML) continue;
    const focused = part.contains(document.activeElement) ? document.activeElement : null;
    // Do not replace an input in which somebody is typing.
    if (focused?.matches("input") && focused.value !== focused.defaultValue) continue;
    const place = focused ? [...part.querySelectorAll(FOCUSABLE)].indexOf(focused) : -1;
    part.replaceWith(document.importNode(other, true));
    if (place >= 0) document.getElementById(part.id).querySelectorAll(FOCUSABLE)[place]?.focus();
  }
  pass();
  const now = document.getElementById("state").dataset.state;
  document.title = now === "fault" ? `⚠ ${title}` : title;
  if (now === "fault" && state !== "fault") beep();
  state = now;
}

// The plate bench: what moves the plate runs only while this page holds it.
setInterval(() => { if (document.querySelector("[data-hold]")) post("hold", {}); }, 1000);

// Elapsed times continue between two answers of the console.
setInterval(() => {
  for (const place of document.querySelectorAll("[data-ticks]")) {
    const seconds = Number(place.dataset.ticks) + 1;
    place.dataset.ticks = seconds;
    place.textContent = `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
  }
}, 1000);

function beep() {
  const audio = new AudioContext();
  const tone = audio.createOscillator();
  tone.frequency.value = 880;
  tone.connect(audio.destination);
  tone.start();
  tone.stop(audio.currentTime + 0.4);
  tone.onended = () => audio.close();
}

const heard = {
  message: refresh,
  error: () => say(document.body.dataset.lost, true),
  open: () => { if (said.textContent === document.body.dataset.lost) say(""); },
};

// One page listens for all pages open in this browser, because browsers allow only six connections
// per host. When that page closes, the next one gets the lock. Each console process has its own
// lock, so that a page left over from an ended console does not block the others.
const ours = `slipscale-${document.body.dataset.console}`;
const others = new BroadcastChannel(ours);
others.onmessage = (event) => heard[event.data]?.();

function listen() {
  const changes = new EventSource("/events");
  for (const kind of Object.keys(heard)) {
    changes.addEventListener(kind, () => { heard[kind](); others.postMessage(kind); });
  }
  changes.addEventListener("error", () => {
    if (changes.readyState === EventSource.CLOSED) setTimeout(listen, AGAIN_MS);
  });
}

navigator.locks.request(ours, () => { listen(); return new Promise(() => {}); });

// The study's editor ------------------------------------------------------------------------------

// The text is the source. A field of the form asks the console for the text with its change made;
// the answer brings text, form and faults. One request at a time: each begins from the last text.
const study = document.getElementById("study-form");
if (study) {
  const text = document.getElementById("study-text");
  const lines = document.getElementById("study-lines");
  const faults = document.getElementById("study-faults");
  const tabs = [...study.querySelectorAll("[role=tab]")];
  const { template } = study.dataset;
  const timers = new Map(); // of what is typed into, until nobody types
  const undo = document.getElementById("study-undo");
  const kept = `slipscale-undo:${template || study.dataset.name}`;
  const before = JSON.parse(sessionStorage.getItem(kept) || "[]"); // earlier texts, the last one last
  let last = text.value; // the text of the last change
  let wrong = new Set();
  let queue = Promise.resolve();

  const number = () => {
    const count = text.value.split("\n").length;
    lines.replaceChildren(...Array.from({ length: count }, (_, at) => {
      const line = document.createElement(wrong.has(at + 1) ? "b" : "span");
      line.textContent = `${wrong.has(at + 1) ? "✗ " : ""}${at + 1}\n`;
      return line;
    }));
    lines.scrollTop = text.scrollTop;
  };
  const send = async (change) => {
    const judged = text.value;
    const answer = await request("/study/edit", { text: judged, template, change });
    if (!answer.good) return say(answer.said, true);
    if (text.value !== judged) return change ? send(change) : undefined; // typed on meanwhile
    if (change) { text.value = answer.text; say(""); }
    remember();
    wrong = new Set(answer.faults.map(([line]) => line));
    faults.textContent = answer.faults.map(([, sentence]) => sentence).join("\n");
    renew(answer.html);
    number();
    later();
  };
  const remember = (undone = false) => {
    if (!undone && text.value !== last) before.push(last);
    before.splice(0, before.length - MOST_UNDONE);
    last = text.value;
    if (undo) undo.disabled = !before.length;
    sessionStorage.setItem(kept, JSON.stringify(before));
  };
  undo?.addEventListener("click", async () => {
    await queue;
    if (!before.length) return;
    text.value = last = before.pop();
    remember(true);
    edit();
  });
  const edit = (change = null) => { queue = queue.then(() => send(change)); return queue; };
  const later = async () => {
    const judged = text.value;
    const answer = await request("/study/later" + location.search, { text: judged, template });
    if (answer.good && judged === text.value) renew(answer.html);
  };
  // What somebody types into keeps what was typed meanwhile, and the cursor.
  const renew = (html) => {
    const fresh = new DOMParser().parseFromString(html, "text/html");
    const active = document.activeElement;
    const typed = active.matches("[data-place]") && { value: active.value, at: active.selectionStart };
    const open = [...document.querySelectorAll("details[open]")].map((each) => each.id);
    for (const part of fresh.querySelectorAll("[data-edit]")) document.getElementById(part.id).replaceWith(part);
    for (const id of open) document.getElementById(id)?.setAttribute("open", "");
    const again = active.id && document.getElementById(active.id);
    if (again && again !== active) {
      again.focus({ preventScroll: true });
      if (typed && timers.has(active.id)) again.value = typed.value;
      if (typed && again.setSelectionRange && again.tagName !== "SELECT") again.setSelectionRange(typed.at, typed.at);
    }
  };
  const valueIn = (input) => (input.dataset.kind === "several"
    ? [...input.querySelectorAll(":checked")].map((each) => each.value).join(" ") : input.value);
  const set = (input) => {
    clearTimeout(timers.get(input.id));
    timers.delete(input.id);
    return edit({ what: "set", place: JSON.parse(input.dataset.place), kind: input.dataset.kind, value: valueIn(input) });
  };
  const soon = (id, then) => {
    clearTimeout(timers.get(id));
    timers.set(id, setTimeout(then, PAUSE_MS));
  };
  const typing = (input) => soon(input.id, () => set(document.getElementById(input.id)));
  study.addEventListener("input", (event) => {
    if (event.target === text) {
      number();
      return soon(text.id, () => { timers.delete(text.id); edit(); });
    }
    const input = event.target.closest("[data-place]");
    if (input) typing(input);
  });
  // Somebody may type before this script runs.
  for (const input of study.querySelectorAll("input[data-place]")) if (input.value !== input.defaultValue) typing(input);
  study.addEventListener("change", (event) => {
    const input = event.target.closest("[data-place]");
    if (input && timers.has(input.id)) set(input);
  });
  study.addEventListener("click", async (event) => {
    const button = event.target.closest("[data-change]");
    if (!button) return;
    const change = JSON.parse(button.dataset.change);
    const from = document.getElementById(button.dataset.valueOf);
    await edit({ ...change, ...(from && { value: from.value }) });
    if (change.what === "move") focusOn(change);
  });
  // After a move the same card's button has the focus, so that it can be pressed again.
  const focusOn = ({ place, to }) => {
    const item = JSON.stringify([...place.slice(0, -1), to]);
    const up = to < place.at(-1);
    const moves = [...study.querySelectorAll("[data-item]")].find((each) => each.dataset.item.replaceAll(" ", "") === item)
      .querySelectorAll(".handle [data-change]");
    [...moves].find((each) => { const c = JSON.parse(each.dataset.change); return c.what === "move" && (c.to < to) === up; })?.focus();
    if (!study.contains(document.activeElement)) moves[0].focus();
  };
  let dragged = null;
  study.addEventListener("dragstart", (event) => { dragged = event.target.closest?.("[data-item]")?.dataset.item ?? null; });
  study.addEventListener("dragover", (event) => { if (dragged && event.target.closest("[data-item]")) event.preventDefault(); });
  study.addEventListener("drop", (event) => {
    const [from, onto] = [dragged, event.target.closest("[data-item]")?.dataset.item].map((each) => each && JSON.parse(each));
    dragged = null;
    if (!from || !onto || String(from.slice(0, -1)) !== String(onto.slice(0, -1))) return;
    event.preventDefault();
    edit({ what: "move", place: from, to: onto.at(-1) });
  });
  const choose = (tab) => {
    for (const each of tabs) {
      each.setAttribute("aria-selected", each === tab);
      each.tabIndex = each === tab ? 0 : -1;
      document.getElementById(each.getAttribute("aria-controls")).hidden = each !== tab;
    }
    tab.focus();
    number();
  };
  for (const [at, tab] of tabs.entries()) {
    tab.addEventListener("click", () => choose(tab));
    tab.addEventListener("keydown", (event) => { if (/^Arrow(Left|Right)$/.test(event.key)) choose(tabs[1 - at]); });
  }
  for (const button of study.querySelectorAll("[data-study]")) {
    button.addEventListener("click", async () => {
      await Promise.all([...timers.keys()].filter((id) => id !== text.id).map((id) => set(document.getElementById(id))));
      await queue;
      const action = button.dataset.study;
      const more = action === "copy" ? { name: study.elements.name.value, template } : { before: study.dataset.before };
      const { good, said: sentence } = await post(action, { text: text.value, ...more });
      faults.textContent = good ? "" : sentence;
      say(sentence, !good);
      if (!good) return;
      text.defaultValue = text.value; // nothing is unsaved
      sessionStorage.setItem("slipscale-said", sentence);
      location.assign("/study"); // a copy is the study in use
    });
  }
  addEventListener("beforeunload", (event) => { if (text.value !== text.defaultValue) event.preventDefault(); });
  text.addEventListener("scroll", () => { lines.scrollTop = text.scrollTop; });
  study.addEventListener("submit", (event) => event.preventDefault());
  remember();
  number();
  later();
}
