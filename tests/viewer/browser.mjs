// A browser that reports whatever a page does that it should not.

import { existsSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const CANDIDATES = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

/** Starts the browser that is installed. */
export async function launch() {
  const executablePath = CANDIDATES.find((path) => path && existsSync(path));
  if (!executablePath) throw new Error("there is no Chromium: set CHROMIUM to its path");
  return chromium.launch({ executablePath, args: ["--no-sandbox", "--disable-gpu"] });
}

/** Opens a page from its file and waits until it shows its map; `complaints` grows with errors and requests. */
export async function open(browser, file, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, ...options });
  const page = await context.newPage();
  const complaints = [];
  const own = pathToFileURL(file).href;
  page.on("console", (message) => { if (["error", "warning"].includes(message.type())) complaints.push(`console: ${message.text()}`); });
  page.on("pageerror", (error) => complaints.push(`error: ${error.message}`));
  page.on("request", (request) => { if (request.url() !== own && !request.url().startsWith("data:")) complaints.push(`request: ${request.url()}`); });
  await page.goto(own);
  // Pages without scripts are ready at once.
  if (await page.locator("#viewer").count() === 0) return { page, context, complaints };
  await page.waitForFunction(() => document.documentElement.dataset.ready === "yes", null, { timeout: 60000 }).catch(async () => {
    complaints.push(`not ready: ${await page.textContent("#loading")}`);
  });
  return { page, context, complaints };
}

/** The rows of the pixel's first tables as numbers: a list of lists of rows of cells, each an array of numbers. */
export function storedRows(page) {
  return page.evaluate(() => [...document.querySelectorAll("#tables table")].map((table) =>
    [...table.querySelectorAll("tbody tr")].map((row) => [...row.cells].map((cell) => {
      const mask = cell.querySelector(".mask");
      return mask ? mask.title : cell.textContent.split(" ").map(Number);
    }))));
}
