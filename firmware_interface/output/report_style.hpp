#pragma once

#include <string_view>

namespace cloister {

/// The report's style sheet: one column that widens to two, light and dark, screen and paper. Plans
/// and charts take their colours from the same variables.
inline constexpr std::string_view kReportStyle = R"css(
:root {
  color-scheme: light dark;
  --paper: #ffffff; --panel: #f5f6f8; --ink: #16191d; --soft: #59626d; --rule: #dde1e6; --grid: #eceef1;
  --one: #1f63c4; --two: #b4552a; --good: #1d7a4a; --bad: #b3261e; --warn-paper: #fdf3e3; --warn-rule: #e2a94b;
}
@media (prefers-color-scheme: dark) {
  :root {
    --paper: #111417; --panel: #1a1e23; --ink: #e6e9ed; --soft: #9aa4af; --rule: #2e343c; --grid: #23282e;
    --one: #74aaff; --two: #f0996a; --good: #5cc48d; --bad: #ff8a80; --warn-paper: #2b2314; --warn-rule: #8a6a2c;
  }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; text-size-adjust: 100%; }
body {
  margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", "Noto Sans", sans-serif;
  font-variant-numeric: tabular-nums;
}
main { max-width: 1120px; margin: 0 auto; padding: 2.25rem 1.25rem 3rem; }
.over { margin: 0; color: var(--soft); font-size: .8125rem; letter-spacing: .06em; text-transform: uppercase; }
h1 { margin: .15rem 0 .5rem; font-size: clamp(1.6rem, 4.5vw, 2.3rem); line-height: 1.15; letter-spacing: -.015em; overflow-wrap: anywhere; }
h2 { margin: 2.75rem 0 .75rem; padding-top: .9rem; border-top: 1px solid var(--rule); font-size: 1.25rem; letter-spacing: -.005em; }
h3 { margin: 0 0 .4rem; font-size: .9375rem; }
p { margin: 0 0 .75rem; max-width: 46rem; }
.lede { font-size: 1.0625rem; color: var(--soft); }
.keys { display: grid; grid-template-columns: repeat(4, 1fr); gap: 1px; margin: 1.5rem 0 0;
  background: var(--rule); border: 1px solid var(--rule); border-radius: 8px; overflow: hidden; }
.keys div { padding: .8rem 1rem .75rem; background: var(--panel); }
.keys dt { color: var(--soft); font-size: .8125rem; }
.keys dd { margin: 0; }
.keys .figure { font-size: 1.55rem; font-weight: 650; line-height: 1.25; letter-spacing: -.015em; white-space: nowrap; }
.keys .figure small { font-size: .95rem; font-weight: 500; letter-spacing: 0; }
.keys .more { color: var(--soft); font-size: .8125rem; line-height: 1.35; }
.note-box { margin: 1.25rem 0 0; padding: .75rem 1rem; background: var(--warn-paper); border: 1px solid var(--warn-rule); border-radius: 8px; }
.note-box p { margin: 0; font-weight: 600; }
.note-box ul { margin: .25rem 0 0; padding-left: 1.1rem; font-size: .9375rem; overflow-wrap: anywhere; max-height: 14rem; overflow-y: auto; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 28rem), 1fr)); gap: 1.75rem 2rem; }
.pair > * { min-width: 0; }
figure { margin: 0; break-inside: avoid; }
figcaption { color: var(--soft); font-size: .875rem; }
svg { display: block; width: 100%; height: auto; font-family: inherit; }
svg text { fill: var(--soft); }
.plan { margin-top: .5rem; padding: .9rem; border: 1px solid var(--rule); border-radius: 8px; }
.plan text { font-size: 17px; }
.pair .plan text { font-size: 27px; }
.plan .label { font-weight: 700; text-anchor: middle; fill: var(--ink); stroke: var(--paper); stroke-width: .28em; paint-order: stroke; stroke-linejoin: round; }
.plan .path { fill: none; stroke: var(--ink); stroke-width: 1.4px; stroke-opacity: .55; stroke-linejoin: round; vector-effect: non-scaling-stroke; }
.plan .rule { fill: none; stroke: var(--soft); stroke-width: 1.2px; vector-effect: non-scaling-stroke; }
.plan .start { fill: var(--paper); stroke: var(--ink); stroke-width: 2px; vector-effect: non-scaling-stroke; }
.plan .end { fill: var(--ink); }
.chart text { font-size: 12px; }
.chart .head { font-size: 14px; font-weight: 600; fill: var(--ink); }
.chart .note { font-size: 12px; font-weight: 400; fill: var(--soft); }
.chart .right { text-anchor: end; }
.chart .middle { text-anchor: middle; }
.chart .warn { fill: var(--bad); }
.chart .grid { stroke: var(--grid); stroke-width: 1; }
.chart .axis { stroke: var(--soft); stroke-width: 1; }
.chart .limit { stroke: var(--bad); stroke-width: 1.25; stroke-dasharray: 6 4; }
.chart .mark { stroke: var(--ink); stroke-width: 1.25; stroke-dasharray: 3 3; }
.chart .line { fill: none; stroke-width: 1.75; stroke-linejoin: round; }
.chart .line.one { stroke: var(--one); } .chart .line.two { stroke: var(--two); }
.chart .area { stroke: none; opacity: .14; }
.chart .one { fill: var(--one); } .chart .two { fill: var(--two); }
.chart .line.one, .chart .line.two { fill: none; }
.scroll { max-height: 30rem; overflow: auto; border: 1px solid var(--rule); border-radius: 8px; -webkit-overflow-scrolling: touch; }
.scroll + p { margin-top: .5rem; }
.scroll.wide { max-height: none; margin-top: 1.5rem; }
table { width: 100%; border-collapse: collapse; font-size: .875rem; line-height: 1.35; }
th, td { padding: .4rem .7rem; text-align: left; vertical-align: baseline; white-space: nowrap; border-bottom: 1px solid var(--grid); }
tr:last-child td { border-bottom: 0; }
th { position: sticky; top: 0; background: var(--panel); color: var(--soft); font-weight: 600; font-size: .8125rem; }
.n { text-align: right; }
td.ids { white-space: normal; min-width: 9rem; }
.chip { display: inline-block; width: .7em; height: .7em; margin-right: .35em; border-radius: 2px; vertical-align: baseline; }
.accepted { color: var(--good); font-weight: 600; }
.rejected { color: var(--bad); }
.soft { color: var(--soft); }
.small { font-size: .875rem; }
code, .mono { font-family: ui-monospace, "SF Mono", Menlo, Consolas, "DejaVu Sans Mono", monospace; font-size: .8125rem; }
.config { columns: 19rem auto; column-gap: 2rem; margin: 0; padding: 0; list-style: none; }
.config li { display: flex; justify-content: space-between; gap: 1rem; padding: .2rem 0; border-bottom: 1px solid var(--grid); break-inside: avoid; }
footer { margin-top: 2.75rem; padding-top: .9rem; border-top: 1px solid var(--rule); color: var(--soft); font-size: .8125rem; overflow-wrap: anywhere; }
@media screen and (max-width: 640px) {
  main { padding: 1.25rem 1rem 2rem; }
  h2 { margin-top: 2rem; }
  .keys { grid-template-columns: 1fr 1fr; }
  .keys div { padding: .65rem .8rem; }
  .keys .figure { font-size: 1.3rem; }
  .plan { padding: .4rem; }
  .plan text, .pair .plan text { font-size: 34px; }
  .chart text, .chart .note { font-size: 15px; }
  .chart .head { font-size: 17px; }
  th, td { padding: .35rem .55rem; }
}
@media print {
  @page { margin: 14mm; }
  :root {
    color-scheme: light;
    --paper: #ffffff; --panel: #f5f6f8; --ink: #000000; --soft: #444b53; --rule: #c9ced5; --grid: #e4e7eb;
    --one: #1f63c4; --two: #b4552a; --good: #1d7a4a; --bad: #b3261e; --warn-paper: #ffffff; --warn-rule: #b98a35;
  }
  body { font-size: 10.5pt; -webkit-print-color-adjust: exact; print-color-adjust: exact; }
  main { max-width: none; padding: 0; }
  h2, h3 { break-after: avoid; }
  h2 { margin-top: 1.5rem; }
  .pair { grid-template-columns: 1fr 1fr; gap: 1rem; }
  .keys { grid-template-columns: repeat(4, 1fr); break-inside: avoid; }
  .keys .figure { font-size: 1.25rem; }
  .scroll, .note-box ul { max-height: none; overflow: visible; }
  table, th { font-size: 7.5pt; }
  th { position: static; }
  th, td { padding: .15rem .3rem; }
  th:last-child, td:last-child { white-space: normal; }
  .config { font-size: 7.5pt; }
  thead { display: table-header-group; }
  tr { break-inside: avoid; }
}
)css";

}  // namespace cloister
