#include "server/ai/ants/tsp_text.h"

#include "shared/core/line_reader.h"

#include <cmath>
#include <utility>
#include <vector>

namespace zoned::ai::pathfinding {

namespace {

using core::parse_number;
using core::quoted;
using core::trimmed;

constexpr double kFarthestPlace = 1e7;  ///< so that no distance is longer than kLongest

struct Point {
    double x = 0.0;
    double y = 0.0;
    bool given = false;
};

class TspReader {
  public:
    explicit TspReader(std::string_view text) : in_(text) {}

    core::Result<TspInstance> read() {
        using Read = core::Result<TspInstance>;
        if (!header() || !coordinates()) {
            return Read::failure(in_.error());
        }
        auto distances = Distances::make(points_.size(), lengths());
        if (!distances) {
            fail(distances.error());
            return Read::failure(in_.error());
        }
        return TspInstance{std::move(name_), std::move(*distances)};
    }

  private:
    bool fail(std::string_view what) { return in_.fail(what); }

    bool header() {
        while (in_.next_written()) {
            const std::string_view line = trimmed(in_.rest());
            if (line == "NODE_COORD_SECTION") {
                return points_.empty() ? fail("no DIMENSION stands before the coordinates")
                       : !weighted_    ? fail("no EDGE_WEIGHT_TYPE stands before the coordinates")
                                       : true;
            }
            const std::size_t colon = line.find(':');
            if (colon == std::string_view::npos) {
                return fail(quoted(line) + " is neither 'KEY : VALUE' nor NODE_COORD_SECTION");
            }
            if (!setting(trimmed(line.substr(0, colon)), trimmed(line.substr(colon + 1)))) {
                return false;
            }
        }
        return fail("the text ends before NODE_COORD_SECTION");
    }

    bool setting(std::string_view key, std::string_view value) {
        if (key == "NAME") {
            name_ = std::string(value.substr(0, 80));
        } else if (key == "TYPE") {
            return value == "TSP" || fail("the type is " + quoted(value) + ", not TSP");
        } else if (key == "EDGE_WEIGHT_TYPE") {
            rounded_up_ = value == "CEIL_2D";
            weighted_ = rounded_up_ || value == "EUC_2D";
            return weighted_ ||
                   fail("the distances are " + quoted(value) + ", neither EUC_2D nor CEIL_2D");
        } else if (key == "DIMENSION") {
            const auto count = parse_number<std::size_t>(value);
            if (!count || *count < 3 || *count > Distances::kMostPlaces) {
                return fail("the dimension is " + quoted(value) +
                            ", not a whole number from 3 to " +
                            std::to_string(Distances::kMostPlaces));
            }
            points_.assign(*count, {});
        } else if (key != "COMMENT" && key != "DISPLAY_DATA_TYPE" && key != "NODE_COORD_TYPE") {
            return fail(quoted(key) + " is not known");
        }
        return true;
    }

    bool coordinates() {
        std::size_t given = 0;
        while (in_.next_written() && trimmed(in_.rest()) != "EOF") {
            if (!coordinate()) {
                return false;
            }
            ++given;
        }
        return given == points_.size() || fail(std::to_string(given) + " nodes are given of " +
                                               std::to_string(points_.size()));
    }

    bool coordinate() {
        const std::string_view node = in_.word();
        const auto number = parse_number<std::size_t>(node);
        if (!number || *number < 1 || *number > points_.size()) {
            return fail("the node is " + quoted(node) + ", not a whole number from 1 to " +
                        std::to_string(points_.size()));
        }
        Point& p = points_[*number - 1];
        if (p.given) {
            return fail("node " + std::to_string(*number) + " is given twice");
        }
        const std::string_view words[] = {in_.word(), in_.word()};
        const auto x = parse_number<double>(words[0]);
        const auto y = parse_number<double>(words[1]);
        if (!x || !y || !(std::abs(*x) <= kFarthestPlace) || !(std::abs(*y) <= kFarthestPlace)) {
            return fail("the place is " + quoted(words[0]) + " " + quoted(words[1]) +
                        ", not two numbers from -1e7 to 1e7");
        }
        p = {*x, *y, true};
        const std::string_view more = in_.word();
        return more.empty() || fail(quoted(more) + " is too much");
    }

    [[nodiscard]] std::vector<Length> lengths() const {
        std::vector<Length> all;
        all.reserve(points_.size() * points_.size());
        for (const Point& a : points_) {
            for (const Point& b : points_) {
                const double dx = a.x - b.x;
                const double dy = a.y - b.y;
                const double d = std::sqrt(dx * dx + dy * dy);
                all.push_back(static_cast<Length>(rounded_up_ ? std::ceil(d) : d + 0.5));
            }
        }
        return all;
    }

    core::LineReader in_;
    std::string name_;
    bool weighted_ = false;
    bool rounded_up_ = false;
    std::vector<Point> points_;
};

}  // namespace

core::Result<TspInstance> parse_tsp(std::string_view text) {
    return TspReader(text).read();
}

}  // namespace zoned::ai::pathfinding
