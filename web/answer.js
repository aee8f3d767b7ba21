// The answer of a file, and what can be taken away.
import { el, figure, save, text } from "./dom.js";
import { record } from "./plot.js";

const heading = (name) => el("h2", {}, text(name));

function parameters(rows) {
  const head = ["parameter", "symbol", "value", "uncertainty", "unit", "interval", "relative"];
  const body = rows.map((row) =>
    el(
      "tr",
      { class: row.absent && "absent" },
      el("th", { scope: "row" }, row.words),
      el("td", {}, row.symbol),
      el("td", { class: "n" }, row.value),
      el("td", { class: "n" }, row.uncertainty),
      el("td", {}, row.unit),
      el("td", {}, row.absent ? text("answer.absent") : row.interval),
      el("td", { class: "n" }, row.relative),
    ),
  );
  const cells = head.map((name) => el("th", { scope: "col" }, text(`answer.${name}`)));
  return scrolled(text("answer.parameters"), el("table", {}, el("thead", {}, el("tr", {}, ...cells)), el("tbody", {}, ...body)));
}

/** Wide tables scroll by themselves, by keyboard too. */
function scrolled(name, table) {
  return el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": name }, table);
}

function table({ title, headings, rows, chosen, note }) {
  const cell = (value, i) => (i ? el("td", { class: "n" }, value) : el("th", { scope: "row" }, value));
  const body = rows.map((row, i) => el("tr", { class: i === chosen && "chosen" }, ...row.map(cell)));
  const head = el("tr", {}, ...headings.map((name) => el("th", { scope: "col" }, name)));
  return el(
    "section",
    {},
    el("h2", {}, title),
    scrolled(title, el("table", {}, el("thead", {}, head), el("tbody", {}, ...body))),
    note ? el("p", { class: "soft" }, note) : null,
  );
}

/** Hints as buttons where the value is known, as a way to the control where it is not. */
export function hints(list, apply) {
  const one = ({ option, value, advice }) => {
    if (!option) return el("li", {}, advice);
    // A word in place of a number (`RATE`) stands for one that the person knows.
    const known = value !== null && !(option.endsWith("_hz") && typeof value === "string");
    const control = document.getElementById(`option-${option}`);
    const label = known ? text("warnings.apply")(option, value) : text("warnings.choose")(option);
    const act = () => (known ? apply(option, value) : control?.focus());
    return el("li", {}, el("button", { type: "button", onclick: act, disabled: !known && !control }, label), ` ${advice}`);
  };
  return el("ul", { class: "hints" }, ...list.map(one));
}

function warnings(list, apply) {
  if (!list.length) return el("p", { class: "soft" }, text("warnings.none"));
  const one = (warning) => el("li", {}, el("p", {}, warning.message), warning.hints.length ? hints(warning.hints, apply) : null);
  return el("section", { class: "warnings" }, heading("warnings.title"), el("ul", {}, ...list.map(one)));
}

function figures(answer, apply, kept) {
  const section = el("section", {}, heading("figures.title"));
  const dialog = document.getElementById("enlarged");
  if (answer.trace) {
    const host = el("div", { class: "record" });
    section.append(el("h3", {}, text("figures.record")), el("p", { class: "soft" }, text("figures.recordHelp")), host);
    const shown = record(host, answer.trace, apply);
    kept.push(shown);
    host.after(el("button", { type: "button", onclick: () => shown.all() }, text("figures.zoomOut")));
  }
  const panels = answer.document.panels.map((svg) => {
    const drawn = figure(svg);
    const name = drawn.querySelector("svg").getAttribute("aria-label");
    const enlarge = () => {
      dialog.querySelector("figure").replaceWith(figure(svg));
      dialog.showModal();
    };
    drawn.append(el("button", { type: "button", class: "quiet", "aria-label": `${text("figures.enlarge")}: ${name}`, onclick: enlarge }, text("figures.enlarge")));
    return drawn;
  });
  section.append(el("div", { class: "figures" }, ...panels));
  return section;
}

function code(name, content, status) {
  const copy = async () => {
    await navigator.clipboard.writeText(content);
    status(text("take.copied"));
  };
  return [
    el("h3", {}, text(name)),
    el("pre", { tabindex: "0" }, el("code", {}, content)),
    navigator.clipboard ? el("button", { type: "button", "aria-label": `${text("take.copy")}: ${text(name)}`, onclick: copy }, text("take.copy")) : null,
  ];
}

function takeAway(file, link, status) {
  const { answer, name } = file;
  const stem = name.replace(/\.[^.]*$/, "") || "slipfit";
  const kinds = [
    ["html", ".html", "text/html"],
    ["svg", ".svg", "image/svg+xml"],
    ["json", ".json", "application/json"],
    ["csv", ".slipfit.csv", "text/csv"],
    ["markdown", ".md", "text/markdown"],
  ];
  const buttons = kinds.map(([what, ending, type]) =>
    el("button", { type: "button", id: `take-${what}`, onclick: () => save(stem + ending, answer[what], type) }, text(`take.${what}`)),
  );
  return el(
    "section",
    { class: "take" },
    heading("take.title"),
    el("div", { class: "buttons" }, ...buttons, el("a", { class: "button", href: link, id: "take-link" }, text("take.link"))),
    el("p", { class: "soft" }, text("take.linkNote")),
    ...code("take.command", answer.command, status),
    ...code("take.python", answer.python, status),
  );
}

/**
 * Everything of one answered file. Plots that must be taken down again are put into `kept`.
 */
export function answered(file, form, apply, link, status, kept) {
  const { answer } = file;
  const { document: said } = answer;
  const facts = said.facts.map(([label, what]) => [el("dt", {}, label.replaceAll("_", " ")), el("dd", {}, what)]);
  return [
    el("section", {}, el("h2", { id: "answer-title", tabindex: "-1" }, said.subject), el("p", { class: "answer", id: "sentence" }, said.sentence)),
    warnings(answer.warnings, apply),
    el("section", {}, heading("answer.parameters"), parameters(said.parameters)),
    figures(answer, apply, kept),
    ...said.tables.map(table),
    el("section", {}, heading("answer.reading"), el("dl", {}, ...facts.flat())),
    el("details", { open: file.formOpen, ontoggle: (event) => (file.formOpen = event.target.open) }, el("summary", {}, text("options.title")), form),
    takeAway(file, link, status),
  ];
}
