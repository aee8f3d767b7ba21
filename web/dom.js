// Elements from data. Text of others only ever becomes text.
import { texts } from "./texts.js";

/**
 * The text of a dotted name, as `drop.choose`; a table of texts, or a function that makes one.
 * @param {string} name
 * @returns {any}
 */
export function text(name) {
  const found = name.split(".").reduce((/** @type {any} */ table, key) => table?.[key], texts);
  if (found === undefined) throw new Error(`no text ${name}`);
  return found;
}

/**
 * An element with attributes, handlers (`onclick`) and children; a text is a text node.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, any>} attributes
 * @param {...(Node | string | null | undefined)} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "value" || name === "checked") Object.assign(element, { [name]: value });
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null).filter((child) => child !== undefined));
  return element;
}

/** Fills the texts of what stands in the page. @param {ParentNode} root */
export function fillTexts(root = document) {
  for (const element of /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll("[data-text]"))) {
    element.textContent = text(element.dataset.text ?? "");
  }
  for (const element of /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll("[data-label]"))) {
    element.setAttribute("aria-label", text(element.dataset.label ?? ""));
  }
}

/** A figure that the core has drawn. Names of others in it are escaped where it is written. @param {string} svg */
export function figure(svg) {
  const parsed = new DOMParser().parseFromString(svg, "text/html").querySelector("svg");
  return el("figure", {}, parsed && document.adoptNode(parsed));
}

/**
 * A picture in pixels, at twice its size.
 * @param {string} svg with its width and height
 * @returns {Promise<Blob>}
 */
export async function png(svg) {
  const url = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  try {
    const image = new Image();
    image.src = url;
    await image.decode();
    const canvas = el("canvas", { width: 2 * image.naturalWidth, height: 2 * image.naturalHeight });
    canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
    return await new Promise((done, fail) => canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error("no picture"))), "image/png"));
  } finally {
    URL.revokeObjectURL(url);
  }
}

/** Hands out text or bytes as a file. @param {string} name @param {BlobPart} content @param {string} type */
export function save(name, content, type) {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = el("a", { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
