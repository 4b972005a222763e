#include "tests/bench/report/page.h"

#include "tests/bench/report/chart.h"

#include <algorithm>

namespace zoned::bench {

namespace {

std::string html_text(const std::string& text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '&':
                out += "&amp;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

std::string two_digits(double value) {
    return short_number(static_cast<double>(static_cast<long>(value * 100.0 + 0.5)) / 100.0);
}

std::string table_html(const std::string& caption,
                       const std::vector<std::string>& columns,
                       const std::vector<std::vector<std::string>>& rows) {
    std::string text = "<table><caption>" + html_text(caption) + "</caption><thead><tr>";
    for (const std::string& column : columns) {
        text += "<th scope=\"col\">" + html_text(column.empty() ? "no." : column) + "</th>";
    }
    text += "</tr></thead><tbody>\n";
    for (const auto& row : rows) {
        text += "<tr>";
        for (const std::string& cell : row) {
            text += "<td>" + html_text(cell) + "</td>";
        }
        text += "</tr>\n";
    }
    return text + "</tbody></table>\n";
}

std::string chart_html(const Chart& chart) {
    return "<h3 id=\"h-" + chart.id + "\">" + html_text(chart.title) +
           "</h3>\n<div class=\"figure\" role=\"group\" aria-labelledby=\"h-" + chart.id +
           "\">\n<div><div class=\"plot\" id=\"" + chart.id +
           "\"><canvas tabindex=\"0\" role=\"img\" aria-label=\"" +
           html_text(chart.title + ". " + chart.y_label + " against " + chart.x_label + ". " +
                     chart.summary + " Arrow keys read the points.") +
           "\"></canvas></div>\n<p class=\"summary-text\">" + html_text(chart.summary) +
           "</p>\n<p class=\"command\">" + html_text(chart.command) +
           "</p></div>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Table: " +
           html_text(chart.title) + "\">" + table_html(chart.title, chart.columns, chart.table) +
           "</div>\n</div>\n";
}

std::string count_row(const char* id, const char* what, const FrontCounts& counts) {
    const std::string prefix = std::string("<td class=\"number\" id=\"") + id;
    return std::string("<tr><th scope=\"row\">") + what + "</th>" + prefix + "-scenes\">" +
           std::to_string(counts.scenes) + "</td>" + prefix + "-default\">" +
           std::to_string(counts.default_on_front) + "</td>" + prefix + "-own\">" +
           std::to_string(counts.own_on_front) + "</td></tr>\n";
}

std::string behind_html(const std::vector<Standing>& standings) {
    std::vector<const Standing*> behind;
    for (const Standing& standing : standings) {
        if (!on_front(standing.default_factor)) {
            behind.push_back(&standing);
        }
    }
    std::sort(behind.begin(), behind.end(), [](const Standing* a, const Standing* b) {
        return a->default_factor > b->default_factor;
    });
    std::string text =
        "<h3>Where our default is not on the front</h3>\n<div class=\"scroll\" tabindex=\"0\" "
        "role=\"region\" aria-label=\"Scenes behind the front\"><table id=\"behind\"><caption>The "
        "factor is our default's time over the least time with no larger error.</caption><thead>"
        "<tr><th scope=\"col\">scene</th><th scope=\"col\">our default</th><th scope=\"col\">best "
        "of ours</th><th scope=\"col\">best peer</th><th scope=\"col\">fastest with no larger "
        "error</th></tr></thead><tbody>\n";
    for (const Standing* standing : behind) {
        const Figure& figure = *standing->figure;
        const std::string id = chart_of(figure, Results()).id;
        text += "<tr><td><a href=\"#h-" + id + "\">" + html_text(figure.heading()) +
                "</a></td><td class=\"bad\">" + two_digits(standing->default_factor) + "</td><td>" +
                two_digits(standing->own_factor) + "</td><td>" +
                (standing->peer_factor > 0.0 ? two_digits(standing->peer_factor) : "none") +
                "</td><td>" + html_text(standing->beaten_by) + "</td></tr>\n";
    }
    return text + "</tbody></table></div>\n";
}

std::string summary_html(const Results& results,
                         const std::vector<Figure>& figures,
                         const std::string& generated_by) {
    const std::vector<Standing> standings = standings_of(figures);
    const FrontCounts peers = count_fronts(standings, true);
    const FrontCounts all = count_fronts(standings, false);
    std::string text =
        "<h2 id=\"summary\">Summary</h2>\n<p>A method is on the front of a scene "
        "when no other method is as exact and more than 5 % faster.</p>\n";
    if (results.quick) {
        text +=
            "<p><strong>A quick run: scenes were cut short. Times hint, errors mean little."
            "</strong></p>\n";
    }
    text +=
        "<table><caption>Scenes on whose front we are</caption><thead><tr><th scope=\"col\">"
        "scenes</th><th scope=\"col\">in all</th><th scope=\"col\">our default</th><th "
        "scope=\"col\">any method of ours</th></tr></thead><tbody>\n" +
        count_row("peers", "with a peer", peers) + count_row("all", "with any other method", all) +
        "</tbody></table>\n" + behind_html(standings);
    text += "<h3>How it was measured</h3>\n<dl class=\"about\"><dt>machine</dt><dd>" +
            html_text(results.machine) + "</dd><dt>build</dt><dd>" + html_text(results.build) +
            "</dd><dt>flags</dt><dd>" + html_text(results.flags) + "</dd><dt>commit</dt><dd>" +
            html_text(results.commit) + "</dd><dt>command</dt><dd><code>" +
            html_text(generated_by) + "</code></dd><dt>rows</dt><dd id=\"rows\">" +
            std::to_string(results.rows.size()) + "</dd></dl>\n";
    return text;
}

constexpr const char* kKey =
    "<h2 id=\"reading\">How to read the plots</h2>\n<p>Both axes are logarithmic. Left is more "
    "exact, down is faster. Numbers beside the marks are those of the table. An error of zero lies "
    "at the left edge.</p>\n<ul class=\"key\"><li>&#9679; circle: our default</li><li>&#9632; "
    "square: our other methods</li><li>&#9651; hollow triangle, dotted: peers, which are other "
    "people's programs</li><li>- - dashed: the front, which no method beats in time and error at "
    "once</li></ul>\n<p>With the focus on a plot, arrow keys go from point to point, Home and End "
    "to "
    "the first and last, Escape leaves.</p>\n";

struct Body {
    std::string text;
    std::string data;
    std::string contents;

    void add(const Chart& chart) {
        text += chart_html(chart);
        data += (data.empty() ? "" : ",") + chart_json(chart);
    }

    void section(const std::string& id, const std::string& title) {
        text += "<h2 id=\"" + id + "\">" + html_text(title) + "</h2>\n";
        contents += "<li><a href=\"#" + id + "\">" + html_text(title) + "</a></li>";
    }
};

void add_figures(Body& body, const std::vector<Figure>& figures, const Results& results) {
    std::string suite;
    for (const Figure& figure : figures) {
        if (figure.suite != suite) {
            suite = figure.suite;
            body.section("suite-" + suite, suite);
        }
        body.add(chart_of(figure, results));
        if (!figure.along_label.empty() && !figure.points.empty()) {
            body.add(along_chart_of(figure, results));
        }
    }
}

void add_growth(Body& body, const Results& results) {
    body.section("growth", "Growth of cost with size");
    body.text +=
        "<p>The exponent is the slope of a straight line through the logarithms of time and "
        "size. Its interval covers the scatter about that line, so that a bend shows as a "
        "wide one.</p>\n";
    const std::vector<Growth> growths = growths_of(results);
    for (const Growth& growth : growths) {
        body.add(chart_of(growth, results));
    }
    if (growths.empty()) {
        body.text += "<p>No scene of this run was measured at three sizes.</p>\n";
    }
}

void add_bandwidth(Body& body, const std::vector<Figure>& figures, const Results& results) {
    body.section("bandwidth", "Bandwidth against error");
    bool any = false;
    for (const Figure& figure : figures) {
        const Chart chart = bandwidth_chart_of(figure, results);
        if (!chart.series.empty()) {
            body.add(chart);
            any = true;
        }
    }
    if (!any) {
        body.text += "<p>This run has no rows of replication.</p>\n";
    }
}

void add_notes(Body& body, const Results& results) {
    if (results.notes.empty()) {
        return;
    }
    body.section("notes", "Notes of the suites");
    body.text += "<ul>\n";
    for (const std::string& note : results.notes) {
        body.text += "<li>" + html_text(note) + "</li>\n";
    }
    body.text += "</ul>\n";
}

/// Text inside a script element must not hold its end.
std::string script_safe(std::string text) {
    for (std::size_t at = text.find("</"); at != std::string::npos; at = text.find("</", at + 3)) {
        text.insert(at + 1, "\\");
    }
    return text;
}

}  // namespace

std::string report_html(const Results& results, const std::string& generated_by) {
    // All suites stand together, whatever the order of the runs.
    std::vector<Figure> figures = figures_of(results);
    std::stable_sort(figures.begin(), figures.end(), [](const Figure& a, const Figure& b) {
        return a.suite < b.suite;
    });
    Body body;
    add_figures(body, figures, results);
    add_growth(body, results);
    add_bandwidth(body, figures, results);
    add_notes(body, results);
    const PageFiles files = page_files();
    std::string page =
        "<!DOCTYPE html>\n<html lang=\"en\" data-theme=\"light\"><head><meta charset=\"utf-8\">"
        "<meta name=\"viewport\" content=\"width=device-width\"><title>zoned-bench: run time "
        "against error</title>\n<style>" +
        std::string(files.style) +
        "</style></head><body>\n<a class=\"skip\" href=\"#summary\">To the summary</a>\n<header>"
        "<h1>Run time against error</h1><p>Our methods beside their peers, measured by zoned-bench."
        "</p><button id=\"theme\" type=\"button\">Dark theme</button>\n<nav "
        "aria-label=\"Contents\"><ul><li><a href=\"#summary\">Summary</a></li><li><a "
        "href=\"#reading\">How to read the plots</a></li>" +
        body.contents + "</ul></nav></header>\n<main>\n" +
        summary_html(results, figures, generated_by) + kKey + body.text;
    std::string end =
        "</main>\n<div id=\"announcer\" class=\"hidden\" aria-live=\"polite\"></div>\n"
        "<script type=\"application/json\" id=\"charts\">[" +
        script_safe(body.data) + "]</script>\n<script>" + files.charts + "</script>\n<script>" +
        files.script + "</script>\n</body></html>\n";
    std::size_t left_out = 0;
    for (const Drawing& picture : results.pictures) {
        const std::string drawing = "<h3>" + html_text(picture.caption) +
                                    "</h3>\n<div class=\"drawing\">" + picture.svg + "</div>\n";
        if (page.size() + drawing.size() + end.size() + 200 < kLargestPage) {
            page += drawing;
        } else {
            ++left_out;
        }
    }
    if (left_out > 0) {
        page += "<p>" + std::to_string(left_out) +
                " pictures of scenes were left out for their size; a folder as report holds them."
                "</p>\n";
    }
    return page + end;
}

}  // namespace zoned::bench
