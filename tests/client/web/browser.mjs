// Opens pages in headless Chromium and tells what a person would meet: errors, requests, what is too
// wide. Whatever is started is stopped by close().
import { createRequire } from "node:module";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const { chromium } = createRequire(join(process.env.ISOLUX_NODE_MODULES, "package.json"))(
  "playwright-core");

export async function startBrowser() {
  const browser = await chromium.launch({
    executablePath: process.env.ISOLUX_CHROMIUM,
    args: [
      "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
      "--disable-background-networking", "--disable-component-update", "--disable-sync",
    ],
  });
  return { open: (path) => openPage(browser, path), close: () => browser.close() };
}

// What comes back is `complaints`' and can `show` the page in another view: a width in pixels, and a
// colour scheme, light or dark.
async function openPage(browser, path) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 } });
  const errors = [];
  const requests = [];
  const address = pathToFileURL(path).href;
  page.on("console", (message) => errors.push(`${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("request", (request) => {
    const url = request.url();
    if (url !== address && !url.startsWith("data:")) requests.push(url);
  });
  await page.goto(address, { waitUntil: "load" });
  await settle(page);
  const show = async ({ width, colorScheme = "light" }) => {
    await page.setViewportSize({ width, height: 900 });
    await page.emulateMedia({ colorScheme });
    await settle(page);
  };
  return { page, errors, requests, show, close: () => page.close() };
}

// Three frames: sizes are observed in the first, charts stand in the second.
function settle(page) {
  return page.evaluate(() => new Promise((done) =>
    requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))));
}

/** Everything that holds for any page of ours, as a list of complaints. */
export async function complaints({ page, errors, requests }) {
  const found = [...errors, ...requests.map((url) => `requests ${url}`)];
  return found.concat(await page.evaluate(() => {
    const list = [];
    const root = document.documentElement;
    if (root.scrollWidth > root.clientWidth) {
      list.push(`is ${root.scrollWidth} wide in a window of ${root.clientWidth}`);
    }
    if (!document.title) list.push("has no title");
    if (root.lang !== "en") list.push("names no language");
    if (document.querySelectorAll("h1").length !== 1) list.push("has not one h1");
    let level = 0;
    for (const heading of document.querySelectorAll("h1, h2, h3, h4")) {
      const next = Number(heading.tagName[1]);
      if (next > level + 1) list.push(`skips to ${heading.tagName} at "${heading.textContent}"`);
      level = next;
    }
    for (const table of document.querySelectorAll("table")) {
      if (!table.caption?.textContent) list.push("has a table without a caption");
    }
    for (const image of document.querySelectorAll("img")) {
      if (!image.alt) list.push("has a picture without words");
      if (!(image.naturalWidth > 1)) list.push(`has a picture that does not show: ${image.alt}`);
    }
    for (const figure of document.querySelectorAll("figure:has(.chart)")) {
      const name = figure.querySelector("h3")?.textContent;
      const chart = figure.querySelector(".chart svg");
      if (!chart) { list.push(`has no chart in "${name}"`); continue; }
      if (!chart.getAttribute("aria-label")) list.push(`has a chart without words: "${name}"`);
      if (chart.getBoundingClientRect().width > figure.clientWidth) list.push(`has too wide a chart: "${name}"`);
      if (/NaN|Infinity|undefined/.test(chart.outerHTML)) list.push(`has a chart of no numbers: "${name}"`);
      if (!marksOf(chart).some((mark) => mark.getBBox().width + mark.getBBox().height > 0)) {
        list.push(`has an empty chart: "${name}"`);
      }
    }
    if (/\b(NaN|undefined|null|Infinity|\[object)\b/.test(document.querySelector("main").innerText)) {
      list.push("shows what is no text: " + document.querySelector("main").innerText.match(/.{0,40}(NaN|undefined|null|Infinity|\[object).{0,40}/)[0]);
    }
    return list;

    // What stands for data: not the frame, axes or grid.
    function marksOf(chart) {
      return [...chart.querySelectorAll("g[aria-label='dot'] *, g[aria-label='line'] path, g[aria-label='bar'] rect")];
    }
  }));
}
