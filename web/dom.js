// Elements from data. Text of others only ever becomes text.
import { texts } from "./texts.js";

/** The text of a dotted name, as `drop.choose`. */
export function text(name) {
  const found = name.split(".").reduce((table, key) => table?.[key], texts);
  if (found === undefined) throw new Error(`no text ${name}`);
  return found;
}

/** An element with attributes, handlers (`onclick`) and children; a text is a text node. */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "value" || name === "checked") element[name] = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/** Fills the texts of what stands in the page. */
export function fillTexts(root = document) {
  for (const element of root.querySelectorAll("[data-text]")) {
    element.textContent = text(element.dataset.text);
  }
  for (const element of root.querySelectorAll("[data-label]")) {
    element.setAttribute("aria-label", text(element.dataset.label));
  }
}

/** A figure that the core has drawn. Names of others in it are escaped where it is written. */
export function figure(svg) {
  const parsed = new DOMParser().parseFromString(svg, "text/html").querySelector("svg");
  return el("figure", {}, document.adoptNode(parsed));
}

/** Hands out text or bytes as a file. */
export function save(name, content, type) {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = el("a", { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
