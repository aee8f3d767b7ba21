// The answer of a file, and what can be taken away.
import { el, figure, png, save, text } from "./dom.js";
import { record } from "./plot.js";
import { zoomable } from "./zoom.js";

/** @param {string} name */
const heading = (name) => el("h2", {}, text(name));

/** @param {ParameterRow[]} rows */
function parameters(rows) {
  const head = ["parameter", "symbol", "value", "uncertainty", "unit", "interval", "relative"];
  const body = rows.map((row) =>
    el(
      "tr",
      { class: row.absent && "absent" },
      el("th", { scope: "row" }, row.words),
      el("td", { class: "symbol" }, row.symbol),
      el("td", { class: "n" }, row.value),
      el("td", { class: "n" }, row.uncertainty),
      el("td", {}, row.unit),
      el("td", {}, row.absent ? text("answer.absent") : row.interval),
      el("td", { class: "n" }, row.relative),
    ),
  );
  const cells = head.map((name) => el("th", { scope: "col", class: name === "symbol" && name }, text(`answer.${name}`)));
  return scrolled(text("answer.parameters"), el("table", { class: "parameters" }, el("thead", {}, el("tr", {}, ...cells)), el("tbody", {}, ...body)));
}

/** Wide tables scroll by themselves, by keyboard too. @param {string} name @param {HTMLElement} table */
function scrolled(name, table) {
  return el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": name }, table);
}

/** @param {TableOfAnswer} table */
function table({ title, headings, rows, chosen, note }) {
  const cell = (/** @type {string} */ value, /** @type {number} */ i) => (i ? el("td", { class: "n" }, value) : el("th", { scope: "row" }, value));
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

/**
 * Hints as buttons where the value is known, as a way to the control where it is not.
 * @param {Hint[]} list
 * @param {Apply} apply
 * @param {HTMLElement | null} form holds the controls
 */
export function hints(list, apply, form) {
  const one = (/** @type {Hint} */ { option, value, advice }) => {
    if (!option) return el("li", {}, advice);
    // A word in place of a number (`RATE`) stands for one that the person knows.
    const known = value !== null && !(option.endsWith("_hz") && typeof value === "string");
    const control = /** @type {HTMLElement | null | undefined} */ (form?.querySelector(`#option-${option}`));
    const label = known ? text("warnings.apply")(option, value) : text("warnings.choose")(option);
    const act = () => {
      if (known) return apply(option, value);
      control?.closest("details")?.setAttribute("open", "");
      control?.focus();
    };
    return el("li", {}, el("button", { type: "button", onclick: act, disabled: !known && !control }, label), ` ${advice}`);
  };
  return el("ul", { class: "hints" }, ...list.map(one));
}

/** @param {Answered["warnings"]} list @param {How} how */
function warnings(list, { apply, form }) {
  if (!list.length) return el("p", { class: "soft" }, text("warnings.none"));
  const one = (/** @type {Answered["warnings"][number]} */ warning) => el("li", {}, el("p", {}, warning.message), warning.hints.length ? hints(warning.hints, apply, form) : null);
  return el("section", { class: "warnings" }, heading("warnings.title"), el("ul", {}, ...list.map(one)));
}

/**
 * A panel with its values and buttons.
 * @param {string} svg
 * @param {(() => void) | null} enlarge
 */
function panel(svg, enlarge) {
  const drawn = figure(svg);
  const picture = /** @type {SVGSVGElement} */ (drawn.querySelector("svg"));
  const name = picture.getAttribute("aria-label");
  /** @param {string} label @param {string} sign @param {() => void} act */
  const button = (label, sign, act) => el("button", { type: "button", class: "quiet", "aria-label": `${text(label)}: ${name}`, onclick: act }, sign);
  const view = zoomable(picture);
  const buttons = view
    ? [button("figures.closer", "+", () => view.zoom(0.7)), button("figures.farther", "−", () => view.zoom(1 / 0.7)), button("figures.zoomOut", text("figures.zoomOut"), view.all)]
    : [];
  if (enlarge) buttons.push(button("figures.enlarge", text("figures.enlarge"), enlarge));
  drawn.append(...(view ? [view.value] : []), el("div", { class: "buttons" }, ...buttons));
  return drawn;
}

/** @param {Answered} answer @param {How} how */
function figures(answer, { apply, kept, width }) {
  const section = el("section", {}, heading("figures.title"));
  const dialog = /** @type {HTMLDialogElement} */ (document.getElementById("enlarged"));
  if (answer.trace) {
    const host = el("div", { class: "record" });
    section.append(el("h3", {}, text("figures.record")), el("p", { class: "soft" }, text("figures.recordHelp")), host);
    const shown = record(host, answer.trace, apply, width);
    kept.push(shown);
    host.after(el("button", { type: "button", onclick: () => shown.all() }, text("figures.zoomOut")));
  }
  const panels = answer.document.panels.map((svg) => {
    const enlarge = () => {
      dialog.querySelector("figure")?.replaceWith(panel(svg, null));
      dialog.showModal();
    };
    return panel(svg, enlarge);
  });
  section.append(el("p", { class: "soft" }, text("figures.help")), el("div", { class: "figures" }, ...panels));
  return section;
}

/** @param {string} name @param {string} content @param {(message: string) => void} status */
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

/** @param {Loaded} file @param {Answered} answer @param {How} how */
function takeAway({ name }, answer, { link, output, status }) {
  // A file handed over by the command is named by its path.
  const stem = (name.split(/[\\/]/).at(-1) ?? "").replace(/\.[^.]*$/, "") || "slipfit";
  /** @type {[string, string, string, () => Promise<BlobPart>][]} */
  const kinds = [
    ["html", ".html", "text/html", () => output("html")],
    ["svg", ".svg", "image/svg+xml", () => output("svg")],
    ["png", ".png", "image/png", async () => png(await output("svg"))],
    ["json", ".json", "application/json", async () => answer.json],
    ["csv", ".slipfit.csv", "text/csv", () => output("csv")],
    ["markdown", ".md", "text/markdown", () => output("markdown")],
  ];
  const buttons = kinds.map(([what, ending, type, make]) => {
    const taken = async () => {
      status(text("take.making")(stem + ending));
      try {
        save(stem + ending, await make(), type);
        status(text("take.made")(stem + ending));
      } catch (error) {
        status(text("take.failed")(stem + ending, error instanceof Error ? error.message : String(error)));
      }
    };
    return el("button", { type: "button", id: `take-${what}`, onclick: taken }, text(`take.${what}`));
  });
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
 * @typedef {object} How
 * @property {HTMLElement} form options of the file
 * @property {Apply} apply
 * @property {string} link
 * @property {(what: string) => Promise<string>} output makes a report, a figure or a table of the answer
 * @property {(message: string) => void} status
 * @property {Plot[]} kept takes the plots that must be taken down again
 * @property {number} width of the place
 */

/**
 * Everything of one answered file.
 * @param {Loaded} file
 * @param {Answered} answer
 * @param {How} how
 */
export function answered(file, answer, how) {
  const { document: said } = answer;
  const facts = said.facts.map(([label, what]) => [el("dt", {}, label.replaceAll("_", " ")), el("dd", {}, what)]);
  return [
    el("section", {}, el("h2", { id: "answer-title", tabindex: "-1" }, said.subject), el("p", { class: "answer", id: "sentence" }, said.sentence)),
    warnings(answer.warnings, how),
    el("section", {}, heading("answer.parameters"), parameters(said.parameters)),
    figures(answer, how),
    ...said.tables.map(table),
    el("section", {}, heading("answer.reading"), el("dl", {}, ...facts.flat())),
    el("details", { open: file.formOpen, ontoggle: (/** @type {Event} */ event) => (file.formOpen = /** @type {HTMLDetailsElement} */ (event.target).open) }, el("summary", {}, text("options.title")), how.form),
    takeAway(file, answer, how),
  ];
}
