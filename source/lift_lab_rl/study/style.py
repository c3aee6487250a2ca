"""Style of the report's page: light or dark by the reader's system, contents beside the text on a wide screen."""

STYLE = """
:root { color-scheme: light dark; --text: #222; --weak: #5c5c5c; --back: #fff; --line: #ddd; --head: #f4f4f4;
  --link: #0b57d0; --good: #1a7f37; --bad: #b3261e; }
@media (prefers-color-scheme: dark) {
  :root { --text: #e4e4e4; --weak: #a5a5a5; --back: #191919; --line: #3a3a3a; --head: #262626; --link: #8ab4f8;
    --good: #6fdd8b; --bad: #ff8a80; }
  figure img { filter: invert(0.902) hue-rotate(180deg); }
}
* { box-sizing: border-box; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 0 auto; padding: 0 1rem 3rem; max-width: 96rem;
  color: var(--text); background: var(--back); }
a { color: var(--link); }
h1 { line-height: 1.2; margin: 1.5rem 0 .5rem; } h2 { margin: 2.2rem 0 .4rem; border-bottom: 1px solid var(--line); }
h2, h3, figure { scroll-margin-top: 1rem; }
main { min-width: 0; overflow-wrap: anywhere; } table { overflow-wrap: normal; }
nav { font-size: 13px; margin: 1rem 0; } nav ul { list-style: none; margin: .2rem 0; padding-left: .8rem; }
nav summary { cursor: pointer; font-weight: 600; } nav > details > ul { padding-left: 0; }
nav a { text-decoration: none; } nav a:hover { text-decoration: underline; }
nav ul ul { display: none; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: .5rem 0 .5rem; font-size: 13px; }
th, td { border-bottom: 1px solid var(--line); padding: .25rem .6rem; text-align: left; vertical-align: top; }
th { background: var(--head); } td { font-variant-numeric: tabular-nums; }
th:first-child, td:first-child { position: sticky; left: 0; background: var(--back); }
th:first-child { background: var(--head); }
td.as { color: var(--good); } td.opposite { color: var(--bad); }
figure { margin: 1.2rem 0; } figure img { max-width: 100%; }
figcaption, .note { color: var(--weak); font-size: 13px; } .notes { padding-left: 1.2rem; }
code { font-size: 12px; background: var(--head); padding: .05rem .3rem; border-radius: .2rem; overflow-wrap: anywhere; }
@media (max-width: 40rem) { th, td { white-space: nowrap; } }
@media (min-width: 64rem) {
  body { display: grid; grid-template-columns: 15rem minmax(0, 1fr); gap: 2.5rem; }
  nav { position: sticky; top: 0; max-height: 100vh; overflow-y: auto; margin: 0; padding: 1.6rem 0; }
  nav { align-self: start; } nav ul ul { display: block; }
}
@media print { nav { display: none; } body { display: block; } }
"""
"""The page's style sheet."""
