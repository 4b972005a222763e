#include "server/ai/ants/tsp_text.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace zoned::ai::pathfinding {

namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr double kFarthestPlace = 1e7;  ///< so that no distance is longer than kLongest

std::string_view trimmed(std::string_view s) {
    const std::size_t begin = s.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) {
        return {};
    }
    return s.substr(begin, s.find_last_not_of(kBlanks) - begin + 1);
}

std::string quoted(std::string_view s) {
    std::string q("'");
    q.append(s.substr(0, 40));
    q.push_back('\'');
    return q;
}

template <class Number>
std::optional<Number> number_of(std::string_view s) {
    Number value{};
    const auto [end, fault] = std::from_chars(s.data(), s.data() + s.size(), value);
    return fault == std::errc() && end == s.data() + s.size() && !s.empty()
               ? std::optional<Number>(value)
               : std::nullopt;
}

struct Point {
    double x = 0.0;
    double y = 0.0;
    bool given = false;
};

class TspReader {
  public:
    explicit TspReader(std::string_view text) : rest_(text) {}

    core::Result<TspInstance> read() {
        using Read = core::Result<TspInstance>;
        if (!header() || !coordinates()) {
            return Read::failure("line " + std::to_string(line_ > 0 ? line_ : 1) + ": " + fault_);
        }
        auto distances = Distances::make(points_.size(), lengths());
        if (!distances) {
            return Read::failure("line " + std::to_string(line_) + ": " + distances.error());
        }
        return TspInstance{std::move(name_), std::move(*distances)};
    }

  private:
    bool fail(std::string what) {
        fault_ = std::move(what);
        return false;
    }

    /// The next line that is not empty; false at the end.
    bool next(std::string_view& line) {
        while (!rest_.empty()) {
            const std::size_t end = rest_.find('\n');
            line = trimmed(rest_.substr(0, end));
            rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
            ++line_;
            if (!line.empty()) {
                return true;
            }
        }
        return false;
    }

    bool header() {
        std::string_view line;
        while (next(line)) {
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
            const auto count = number_of<std::size_t>(value);
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
        std::string_view line;
        std::size_t given = 0;
        while (next(line) && line != "EOF") {
            if (!coordinate(line)) {
                return false;
            }
            ++given;
        }
        return given == points_.size() || fail(std::to_string(given) + " nodes are given of " +
                                               std::to_string(points_.size()));
    }

    bool coordinate(std::string_view line) {
        const auto word = [&line] {
            const std::size_t end = std::min(line.find_first_of(kBlanks), line.size());
            const std::string_view w = line.substr(0, end);
            line = trimmed(line.substr(end));
            return w;
        };
        const std::string_view node = word();
        const auto number = number_of<std::size_t>(node);
        if (!number || *number < 1 || *number > points_.size()) {
            return fail("the node is " + quoted(node) + ", not a whole number from 1 to " +
                        std::to_string(points_.size()));
        }
        Point& p = points_[*number - 1];
        if (p.given) {
            return fail("node " + std::to_string(*number) + " is given twice");
        }
        const std::string_view words[] = {word(), word()};
        const auto x = number_of<double>(words[0]);
        const auto y = number_of<double>(words[1]);
        if (!x || !y || !(std::abs(*x) <= kFarthestPlace) || !(std::abs(*y) <= kFarthestPlace)) {
            return fail("the place is " + quoted(words[0]) + " " + quoted(words[1]) +
                        ", not two numbers from -1e7 to 1e7");
        }
        p = {*x, *y, true};
        return line.empty() || fail(quoted(line) + " is too much");
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

    std::string_view rest_;
    int line_ = 0;
    std::string fault_;
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
