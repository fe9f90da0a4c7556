/* Bundles entry.js into ../vendor.js, under the notices of both libraries, with uPlot's style sheet beside it. */
const { buildSync } = require("esbuild");
const { copyFileSync, readFileSync } = require("node:fs");

const notices = ["three", "uplot"].map((name) => {
  const version = require(`./node_modules/${name}/package.json`).version;
  return `${name} ${version}\n\n${readFileSync(`node_modules/${name}/LICENSE`, "utf8").trim()}\n`;
});
buildSync({
  entryPoints: ["entry.js"],
  outfile: "../vendor.js",
  bundle: true,
  minify: true,
  format: "iife",
  charset: "utf8",
  legalComments: "none",
  banner: { js: `/*!\n${notices.join("\n")}*/` },
});
copyFileSync("node_modules/uplot/dist/uPlot.min.css", "../vendor.css");
