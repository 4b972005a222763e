#include "tests/bench/report/chart.h"
#include "tests/bench/report/page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace zoned::bench {

namespace {

constexpr double kPictureWidth = 900.0;
constexpr double kNames = 310.0;  // room for the names of scenes
constexpr double kEdge = 20.0;
constexpr double kHead = 92.0;
constexpr double kLine = 14.0;

template <class... Values>
std::string svg_text(const char* pattern, Values... values) {
    std::array<char, 512> text{};
    std::snprintf(text.data(), text.size(), pattern, values...);
    return text.data();
}

std::string svg_escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
    }
    return out;
}

double place_of(double factor, double largest_factor) {
    const double share = std::log(std::max(factor, 1.0)) / std::log(largest_factor);
    return kNames + share * (kPictureWidth - kNames - kEdge);
}

std::string mark(double x, double y, Role role) {
    if (role == Role::kPeer) {
        return svg_text("<path class=\"peer\" d=\"M%.1f %.1fl5 9h-10z\"/>\n", x, y - 5.0);
    }
    if (role == Role::kOwn) {
        return svg_text("<rect class=\"own\" x=\"%.1f\" y=\"%.1f\" width=\"8\" height=\"8\"/>\n",
                        x - 4.0,
                        y - 4.0);
    }
    return svg_text("<circle class=\"default\" cx=\"%.1f\" cy=\"%.1f\" r=\"4.5\"/>\n", x, y);
}

std::string label(double x, double y, const char* anchor, const std::string& text) {
    return svg_text("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">", x, y, anchor) +
           svg_escaped(text) + "</text>\n";
}

std::string legend(const FrontCounts& counts, const Results& results) {
    std::string text =
        label(kEdge,
              22.0,
              "start",
              "Time over the front: 1 is on it. Of " + std::to_string(counts.scenes) +
                  " scenes with a peer, our default is on the front of " +
                  std::to_string(counts.default_on_front) + ", any method of ours of " +
                  std::to_string(counts.own_on_front) + ".");
    text += label(kEdge,
                  42.0,
                  "start",
                  results.machine + "; " + results.build + "; commit " + results.commit +
                      (results.quick ? "; quick run" : ""));
    const std::array<const char*, 3> kNamesOfRoles{"our default", "best of ours", "best peer"};
    for (int i = 0; i < 3; ++i) {
        const double x = kEdge + 8.0 + 130.0 * i;
        text += mark(x, 60.0, static_cast<Role>(i)) +
                label(x + 12.0, 64.0, "start", kNamesOfRoles.at(static_cast<std::size_t>(i)));
    }
    return text;
}

}  // namespace

std::string summary_svg(const Results& results) {
    const std::vector<Figure> figures = figures_of(results);
    std::vector<Standing> standings = standings_of(figures);
    const FrontCounts counts = count_fronts(standings, true);
    std::erase_if(standings, [](const Standing& s) { return s.peer_factor == 0.0; });
    std::stable_sort(standings.begin(), standings.end(), [](const Standing& a, const Standing& b) {
        return a.default_factor < b.default_factor;
    });
    double most = 10.0;
    for (const Standing& s : standings) {
        most = std::max({most, s.default_factor, s.own_factor, s.peer_factor});
    }
    const double height = kHead + kLine * static_cast<double>(standings.size()) + kEdge;
    std::string svg =
        svg_text(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" role=\"img\" "
            "aria-label=\"Time over the front, by scene\">\n",
            kPictureWidth,
            height) +
        "<style>text{font:12px sans-serif;fill:#1a1a1a}.back{fill:#fff}.grid{stroke:#ccc}"
        ".default{fill:#0b57b0}.own{fill:none;stroke:#1b6e2f;stroke-width:1.5}"
        ".peer{fill:none;stroke:#b3400a;stroke-width:1.5}"
        "@media(prefers-color-scheme:dark){text{fill:#e8e8e8}.back{fill:#14171a}.grid{stroke:#444}"
        ".default{fill:#7fb5f5}.own{stroke:#7bd58f}.peer{stroke:#ffb083}}</style>\n"
        "<rect class=\"back\" width=\"100%\" height=\"100%\"/>\n" +
        legend(counts, results);
    for (double decade = 1.0; decade <= most; decade *= 10.0) {
        const double x = place_of(decade, most);
        svg += svg_text("<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>\n",
                        x,
                        kHead - 8.0,
                        x,
                        height - kEdge);
        svg += label(x, kHead - 12.0, "middle", short_number(decade));
    }
    double y = kHead + 4.0;
    for (const Standing& standing : standings) {
        svg += label(kNames - 14.0, y + 4.0, "end", standing.figure->heading());
        svg += mark(place_of(standing.own_factor, most), y, Role::kOwn);
        svg += mark(place_of(standing.peer_factor, most), y, Role::kPeer);
        svg += mark(place_of(standing.default_factor, most), y, Role::kDefault);
        y += kLine;
    }
    return svg + "</svg>\n";
}

}  // namespace zoned::bench
