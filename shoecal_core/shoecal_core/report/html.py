"""A report page as one HTML file: nothing is loaded from elsewhere.

Nothing runs in it but the script of its animations, where there are any.
"""

from __future__ import annotations

from pathlib import Path

import jinja2
from markupsafe import Markup

from shoecal_core.files import atomic_write
from shoecal_core.report import player
from shoecal_core.report.page import Page
from shoecal_core.report.palette import variables
from shoecal_core.report.quantities import PLUS_MINUS, UNKNOWN, true_minus

PAGE = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; style-src 'unsafe-inline'
 {%- if page.animated %}; script-src {{ script_hash }}{% endif %}">
<title>{{ page.title }}</title>
<style>
{{ style }}
</style>
</head>
<body>
<header>
<p class="brand">shoecal</p>
<h1>{{ page.title }}</h1>
<p class="subtitle">{{ page.subtitle }}</p>
</header>
<main>
<section class="verdict {{ page.verdict.level | lower }}">
<p class="level"><span class="sign">{{ signs[page.verdict.level] }}</span>
{{ page.verdict.label or page.verdict.level }}</p>
<div>
<p class="meaning">{{ page.verdict.meaning }}</p>
{% for line in page.verdict.lines %}
<p class="line">{{ line }}</p>
{% endfor %}
{% if page.verdict.reasons %}
<ul>
{% for reason in page.verdict.reasons %}
<li class="{{ reason.level | lower }}"><b>{{ reason.level }}</b> {{ reason.text | true_minus }}</li>
{% endfor %}
</ul>
{% endif %}
</div>
</section>
{% if page.provenance %}
<ul class="provenance">
{% for line in page.provenance %}
<li>{{ line }}</li>
{% endfor %}
</ul>
{% endif %}
<dl class="keys" style="--columns:{{ columns(page.key_figures | length) }};
--printed:{{ columns(page.key_figures | length, most_printed) }}">
{% for key in page.key_figures %}
{% set value, mark, spread = key.value.partition(plus_minus) %}
<div><dt>{{ key.label }}</dt>
<dd>{{ value }}{% if mark %} <small>±&nbsp;{{ spread }}</small>{% endif %}</dd>
{% if key.note %}
<dd class="note">{{ key.note }}</dd>
{% endif %}
</div>
{% endfor %}
</dl>
<nav>
{% for section in page.sections %}
<a href="#section-{{ loop.index }}">{{ section.title }}</a>
{% endfor %}
</nav>
{% for section in page.sections %}
<section id="section-{{ loop.index }}">
<h2>{{ section.title }}</h2>
{% if section.text %}
<p class="text">{{ section.text }}</p>
{% endif %}
{% for group in section.groups %}
{% if group.title %}
<h3>{{ group.title }}</h3>
{% endif %}
{% if group.text %}
<p class="text">{{ group.text | true_minus }}</p>
{% endif %}
{% if group.player %}
<figure class="player" hidden>
<h4>{{ group.player.title }}</h4>
<div class="views">
{% for view in group.player.views %}
{% set left, top, width, height = view.box %}
<div><p>{{ view.title }}</p>
<svg viewBox="{{ view.box | join(' ') }}" font-size="{{ 0.03 * [width, height] | max }}" role="img"
 aria-label="The robot {{ view.title }}">
<g class="scale"><path d="M{{ left + width }} {{ top + height - 5 }}v4h-100v-4"/>
<text x="{{ left + width - 105 }}" y="{{ top + height - 5 }}">100 mm</text></g></svg></div>
{% endfor %}
</div>
<p class="marks"><span class="left">left leg</span><span class="right">right leg</span>
<span class="body">body</span><span class="com">CoM</span>
<span class="cop">CoP (the CoM’s ground projection)</span></p>
<div class="controls">
<button type="button">Play</button>
<input type="range" min="0" max="{{ group.player.duration }}" step="0.1"
 value="{{ group.player.duration / 2 }}" aria-label="Time">
<output></output>
<label>Speed <select>
{% for speed in speeds %}
<option value="{{ speed }}"{% if speed == usual_speed %} selected{% endif %}>{{ speed }}×</option>
{% endfor %}
</select></label>
</div>
<script type="application/json">{{ group.player.data | svg }}</script>
{% if group.player.caption %}
<figcaption>{{ group.player.caption }}</figcaption>
{% endif %}
</figure>
{% endif %}
{% set paired = group.pictures | length == 1 and group.tables %}
{% if paired %}
<div class="paired">
{% endif %}
{% if group.pictures %}
<div class="pictures">
{% for picture in group.pictures %}
<figure{% if picture.tall %} class="tall"{% endif %}>
<h4>{{ picture.title }}</h4>
{{ picture.svg | svg }}
{% if picture.caption %}
<figcaption>{{ picture.caption }}</figcaption>
{% endif %}
</figure>
{% endfor %}
</div>
{% endif %}
{% if group.tables %}
<div class="tables">
{% for table in group.tables %}
<div class="table">
<table>
<caption>{{ table.title }}</caption>
{% if table.header | join %}
<thead><tr>
{% for heading in table.header %}
<th scope="col">{{ heading }}</th>
{% endfor %}
</tr></thead>
{% endif %}
<tbody>
{% for row in table.rows %}
<tr><th scope="row">{{ row[0] }}</th>
{% for cell in row[1:] %}
<td data-label="{{ table.header[loop.index] }}"{% if cell == unknown %} class="unknown"{% endif %}>
{{- cell | true_minus }}</td>
{% endfor %}
</tr>
{% endfor %}
</tbody>
</table>
{% if table.note %}
<p class="note">{{ table.note }}</p>
{% endif %}
</div>
{% endfor %}
</div>
{% endif %}
{% if paired %}
</div>
{% endif %}
{% endfor %}
</section>
{% endfor %}
</main>
{% if page.animated %}
<script>{{ script | svg }}</script>
{% endif %}
</body>
</html>
"""
STYLE = """\
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%;text-size-adjust:100%}
body{margin:0 auto;max-width:1400px;padding:20px 32px 48px;background:var(--paper);
 color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",
 Arial,sans-serif;overflow-wrap:anywhere}
h1,h2,h3,h4,p,ul,dl,dd,figure{margin:0;padding:0}
h1{font-size:26px;line-height:1.25;font-weight:650}
h2{font-size:20px;font-weight:650;margin:40px 0 6px;padding-top:14px;
 border-top:1px solid var(--rule)}
h3{font-size:16px;font-weight:650;margin:26px 0 8px}
h4{font-size:14px;font-weight:600;margin:0 0 8px}
.brand{color:var(--muted);font-size:13px;letter-spacing:.08em;text-transform:uppercase}
.subtitle,.text,.note,figcaption,.provenance{color:var(--muted)}
.text{max-width:76ch;margin:4px 0 12px}
.verdict{display:flex;gap:20px;align-items:flex-start;margin:18px 0 12px;padding:18px 20px;
 background:var(--card);border:1px solid var(--rule);border-left:6px solid var(--level);
 border-radius:8px}
.pass{--level:var(--pass)}
.warn{--level:var(--warn)}
.fail{--level:var(--fail)}
.level{display:flex;align-items:center;gap:10px;font-size:24px;font-weight:700;line-height:1.2;
 color:var(--level);white-space:nowrap}
.sign{display:inline-grid;place-items:center;width:34px;height:34px;border-radius:50%;
 border:2.5px solid currentColor;font-size:19px}
.meaning{font-size:17px;font-weight:600;line-height:34px}
.line{margin-top:6px;max-width:90ch}
.verdict ul{list-style:none;margin-top:4px}
.verdict li{margin-top:4px}
.verdict b{color:var(--level);margin-right:4px}
.provenance{list-style:none;font-size:13px;margin:0 0 16px}
.keys{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,170px),1fr));gap:12px}
.keys div{background:var(--card);border:1px solid var(--rule);border-radius:8px;
 padding:12px 14px}
.keys dt{color:var(--muted);font-size:13px}
.keys dd{font-size:19px;font-weight:650;font-variant-numeric:tabular-nums;line-height:1.4}
.keys small{font-size:13px;font-weight:500;white-space:nowrap}
.keys dd.note{font-size:13px;font-weight:400;line-height:1.4}
@media (min-width:1000px){
.keys{grid-template-columns:repeat(var(--columns),minmax(0,1fr))}
.paired{display:grid;grid-template-columns:minmax(0,1fr) minmax(0,2fr);gap:14px;
 align-items:start;margin-top:10px}
.paired>.pictures,.paired>.tables{margin-top:0}
.paired .pictures{grid-template-columns:minmax(0,1fr)}
}
nav{display:flex;flex-wrap:wrap;gap:4px 18px;margin:18px 0 0}
a{color:var(--blue);text-underline-offset:3px}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,340px),1fr));
 gap:14px;grid-auto-flow:dense;align-items:start;margin-top:10px}
figure{background:var(--card);border:1px solid var(--rule);border-radius:8px;
 padding:12px 12px 10px;break-inside:avoid;min-width:0}
figure.tall{grid-row:span 2}
figure svg{display:block;width:100%;max-width:470px;height:auto;margin:0 auto;overflow:visible;
 stroke-linejoin:round;stroke-linecap:butt}
figcaption,.note{font-size:13px;line-height:1.45}
figcaption{margin-top:8px}
.tables{display:grid;gap:14px;margin-top:14px}
.table{background:var(--card);border:1px solid var(--rule);border-radius:8px;
 padding:12px 14px;break-inside:avoid;overflow-x:auto}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums;font-size:14px}
caption{text-align:left;font-weight:600;font-size:14px;padding-bottom:6px}
th,td{padding:5px 14px 5px 0;text-align:left;border-bottom:1px solid var(--rule);
 vertical-align:top;overflow-wrap:break-word}
thead th{color:var(--muted);font-weight:500;font-size:13px}
tbody th{font-weight:500}
tbody tr:last-child>*{border-bottom:0}
.table .note{margin-top:6px}
@media (max-width:640px){
body{padding:12px 12px 32px}
h1{font-size:21px}
h2{margin-top:28px}
.verdict{flex-direction:column;gap:6px;padding:14px}
.meaning{line-height:1.4}
.keys{grid-template-columns:1fr 1fr;gap:8px}
.keys div{padding:9px 10px}
.keys dd{font-size:17px}
.keys dd.note,.keys dt{font-size:12px}
figure{padding:10px 8px 8px}
table,caption,tbody,tr,tbody th,td{display:block}
thead{display:none}
tbody tr{padding:7px 0;border-bottom:1px solid var(--rule)}
tbody tr:last-child{border-bottom:0}
th,td{border:0;padding:1px 0}
td{display:flex;justify-content:space-between;gap:14px;text-align:right}
td.unknown:not([data-label=""]){display:none}
td[data-label=""]{justify-content:flex-start;text-align:left}
td[data-label=""]::before{content:none}
td::before{content:attr(data-label);flex:0 1 40%;color:var(--muted);text-align:left;
 overflow-wrap:normal}
}
@page{size:A4 landscape;margin:10mm}
@media print{
body{background:none;padding:0;max-width:none;font-size:10pt}
nav{display:none}
h2,h3,.text{break-after:avoid}
h2{margin-top:20px}
h3{margin-top:12px}
.text{break-inside:avoid;margin:2px 0 6px}
.pictures{grid-template-columns:repeat(3,1fr);gap:8px}
.keys{grid-template-columns:repeat(var(--printed),minmax(0,1fr))}
.paired{display:grid;grid-template-columns:minmax(0,1fr) minmax(0,2fr);gap:8px;align-items:start}
.paired>.pictures,.paired>.tables{margin-top:0}
.paired .pictures{grid-template-columns:minmax(0,1fr)}
figure{padding:6px 8px}
h4{margin-bottom:3px}
.table{overflow:visible}
table{font-size:9pt}
th,td{padding:3px 8px 3px 0}
}
"""
FEWEST_KEYS, MOST_KEYS, MOST_PRINTED_KEYS = 4, 7, 5
"""Columns of key figures on a wide page, and on paper."""
SIGNS = {"PASS": "✓", "WARN": "!", "FAIL": "✕"}
"""In addition to the colours, for those who do not see them."""


def render(page: Page) -> str:
    """The page as HTML; every text is escaped, so no name can break or enter it."""
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["svg"] = Markup
    environment.filters["true_minus"] = true_minus
    style = f"{variables()}\n{STYLE}{player.STYLE if page.animated else ''}"
    # Style and hash are made from constants of this package.
    return environment.from_string(PAGE).render(
        page=page, style=Markup(style), signs=SIGNS, plus_minus=PLUS_MINUS,  # noqa: S704
        unknown=UNKNOWN, columns=key_columns, most_printed=MOST_PRINTED_KEYS,
        script=player.SCRIPT, script_hash=Markup(player.script_hash()),  # noqa: S704
        speeds=player.SPEEDS, usual_speed=player.USUAL_SPEED,
    )  # fmt: skip


def key_columns(count: int, most: int = MOST_KEYS) -> int:
    """Columns in which key figures fill rows of equal length, as far as can be."""
    rows = max(1, -(-count // most))
    return max(FEWEST_KEYS, -(-count // rows))


def write_page(path: Path, page: Page) -> None:
    """Write the page, whole or not at all.

    Raises:
        FileError: when it cannot be written.
    """
    atomic_write(path, render(page).encode(errors="replace"))
