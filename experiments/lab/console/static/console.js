// The pages are made by the console itself. This script sends what buttons ask for, and brings a
// page's parts up to date when the console says that something has changed.
"use strict";

const said = document.getElementById("said");
const sure = document.getElementById("sure");
const title = document.title;
const PAUSE_MS = 400; // what is typed is judged once nobody has typed for so long
const AGAIN_MS = 2000; // a refused stream is not tried again by the browser
let state = document.getElementById("state").dataset.state;

function say(sentence, bad = false) {
  said.textContent = sentence;
  said.classList.toggle("bad", bad);
}

async function post(action, fields) {
  const answer = await fetch(`/do/${action}`, {
    method: "POST",
    headers: { "content-type": "application/json", "x-slipscale": "1" },
    body: JSON.stringify(fields),
  }).catch(() => null);
  const told = answer ? await answer.json().catch(() => ({ said: "?" })) : { said: document.body.dataset.lost };
  return { good: Boolean(answer && answer.ok), said: told.said };
}

async function ask(action, fields) {
  const { good, said: sentence } = await post(action, fields);
  say(sentence, !good);
  await refresh();
}

// Asks whether something is meant, and for words or a choice where they are needed.
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

function valueOf(input) {
  if (input.type === "checkbox") return input.checked;
  return input.type === "number" ? Number(input.value) : input.value;
}

document.addEventListener("submit", async (event) => {
  const form = event.target.closest("[data-form]");
  if (!form) return;
  event.preventDefault();
  const inputs = [...form.elements].filter((input) => input.name);
  const fields = Object.fromEntries(inputs.map((input) => [input.name, valueOf(input)]));
  if (!form.dataset.more) return ask(form.dataset.form, fields);
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
  event.preventDefault(); // else the letter is typed into the dialog that opens
  button.click();
});

// Up to date ------------------------------------------------------------------------------------

async function refresh() {
  const answer = await fetch(location.href, { headers: { accept: "text/html" } }).catch(() => null);
  if (!answer || !answer.ok) return;
  const fresh = new DOMParser().parseFromString(await answer.text(), "text/html");
  if (fresh.body.dataset.console !== document.body.dataset.console) return location.reload();
  for (const part of document.querySelectorAll("[data-live]")) {
    const other = fresh.getElementById(part.id);
    // What somebody types into stays as it is.
    if (!other || other.outerHTML === part.outerHTML) continue;
    if (part.contains(document.activeElement) && document.activeElement.matches("input")) continue;
    const focused = part.contains(document.activeElement) ? document.activeElement : null;
    const place = focused ? [...part.querySelectorAll("button, a")].indexOf(focused) : -1;
    part.replaceWith(document.importNode(other, true));
    if (place >= 0) document.getElementById(part.id).querySelectorAll("button, a")[place]?.focus();
  }
  const now = document.getElementById("state").dataset.state;
  document.title = now === "fault" ? `⚠ ${title}` : title;
  if (now === "fault" && state !== "fault") beep();
  state = now;
}

// Times since a beginning go on between two answers of the console.
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

// One page listens for all that this browser has open: it allows six lines to a host, and a line for
// each page would leave none for the seventh. When that page closes, the next has the lock. Each
// console's process has its own lock: a page of one that has ended keeps nobody from listening.
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

const study = document.getElementById("study-form");
if (study) {
  const text = document.getElementById("study-text");
  const lines = document.getElementById("study-lines");
  const faults = document.getElementById("study-faults");
  let wrong = new Set();
  const number = () => {
    const count = text.value.split("\n").length;
    lines.replaceChildren(...Array.from({ length: count }, (_, at) => {
      const line = document.createElement(wrong.has(at + 1) ? "b" : "span");
      line.textContent = `${wrong.has(at + 1) ? "✗ " : ""}${at + 1}\n`;
      return line;
    }));
    lines.scrollTop = text.scrollTop;
  };
  let typing = 0; // the timer that waits until nobody types
  const judge = async (action, aloud = true) => {
    clearTimeout(typing);
    const judged = text.value;
    const fields = { text: text.value, ...(action === "copy" ? { name: study.elements.name.value } : { before: study.dataset.before }) };
    const { good, said: sentence } = await post(action, fields);
    if (!aloud && judged !== text.value) return; // typed on meanwhile
    wrong = new Set([...sentence.matchAll(/(?:^\s+|: )line (\d+)\b/gm)].map((found) => Number(found[1])));
    faults.textContent = good ? "" : sentence;
    if (aloud) say(good ? sentence : "", false);
    number();
    if (good && action === "save") location.reload();
  };
  text.addEventListener("input", () => {
    number();
    clearTimeout(typing);
    if (!text.readOnly) typing = setTimeout(() => judge("validate", false), PAUSE_MS);
  });
  text.addEventListener("scroll", () => { lines.scrollTop = text.scrollTop; });
  for (const button of study.querySelectorAll("[data-study]")) {
    button.addEventListener("click", () => judge(button.dataset.study));
  }
  study.addEventListener("submit", (event) => event.preventDefault());
  number();
}
