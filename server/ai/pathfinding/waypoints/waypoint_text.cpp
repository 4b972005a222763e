#include "server/ai/pathfinding/waypoints/waypoint_graph.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <unordered_map>

namespace zoned::ai::pathfinding {

namespace {

constexpr std::string_view kBlanks = " \t\r";

/// Words of a line before its comment.
class Words {
  public:
    explicit Words(std::string_view line) : rest_(line.substr(0, line.find('#'))) {}

    /// Empty at the end.
    std::string_view next() {
        const std::size_t begin = std::min(rest_.find_first_not_of(kBlanks), rest_.size());
        rest_.remove_prefix(begin);
        const std::size_t end = std::min(rest_.find_first_of(kBlanks), rest_.size());
        const std::string_view word = rest_.substr(0, end);
        rest_.remove_prefix(end);
        return word;
    }

    template <class T>
    std::optional<T> number() {
        const std::string_view word = next();
        T value{};
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (word.empty() || error != std::errc() || end != word.data() + word.size()) {
            return std::nullopt;
        }
        return value;
    }

  private:
    std::string_view rest_;
};

struct WrittenEdge {
    WaypointEdge edge;
    bool length = false;  ///< its weight is its length
    bool both = false;
    int line = 0;
};

class WaypointReader {
  public:
    core::Result<WaypointGraph> read(std::string_view text) {
        for (int line = 1; !text.empty(); ++line) {
            const std::size_t end = std::min(text.find('\n'), text.size());
            read_line(Words(text.substr(0, end)), line);
            text.remove_prefix(std::min(end + 1, text.size()));
            if (!error_.empty()) {
                return core::Result<WaypointGraph>::failure(error_);
            }
        }
        std::vector<WaypointEdge> edges;
        for (const WrittenEdge& e : written_) {
            if (!take(e, edges)) {
                return core::Result<WaypointGraph>::failure(error_);
            }
        }
        auto graph = WaypointGraph::build(waypoints_, edges);
        if (!graph) {
            return core::Result<WaypointGraph>::failure("line " + std::to_string(last_line_) +
                                                        ": " + graph.error());
        }
        return graph;
    }

  private:
    bool fail(int line, const std::string& what) {
        if (error_.empty()) {
            error_ = "line " + std::to_string(line) + ": " + what;
        }
        return false;
    }

    void read_line(Words words, int line) {
        last_line_ = line;
        const std::string_view kind = words.next();
        if (kind == "node") {
            read_node(words, line);
        } else if (kind == "edge") {
            read_edge(words, line);
        } else if (!kind.empty()) {
            fail(line, "a line begins with node or edge");
        }
    }

    bool read_node(Words& words, int line) {
        const auto id = words.number<std::uint32_t>();
        const auto x = words.number<float>();
        const auto y = words.number<float>();
        const auto z = words.number<float>();
        if (!id || !x || !y || !z || !std::isfinite(*x) || !std::isfinite(*y) ||
            !std::isfinite(*z)) {
            return fail(line, "expected: node ID X Y Z [blocked]");
        }
        const std::string_view last = words.next();
        if ((!last.empty() && last != "blocked") || !words.next().empty()) {
            return fail(line, "after a node's place only 'blocked' may follow");
        }
        if (waypoints_.size() == WaypointGraph::kMostWaypoints) {
            return fail(line, "too many nodes");
        }
        if (!number_.try_emplace(*id, waypoints_.size()).second) {
            return fail(line, "node " + std::to_string(*id) + " is given twice");
        }
        waypoints_.push_back({*id, Vec3(*x, *y, *z), last.empty()});
        return true;
    }

    bool read_edge(Words& words, int line) {
        WrittenEdge e;
        e.line = line;
        const auto from = words.number<std::uint32_t>();
        const auto to = words.number<std::uint32_t>();
        Words again = words;
        e.length = words.next() == "length";
        const auto weight = e.length ? std::optional<float>(0.0F) : again.number<float>();
        if (!from || !to || !weight) {
            return fail(line, "expected: edge FROM TO WEIGHT [both]");
        }
        if (!(*weight >= 0.0F) || !std::isfinite(*weight)) {
            return fail(line, "a weight is 0 or more");
        }
        const std::string_view last = words.next();
        if ((!last.empty() && last != "both") || !words.next().empty()) {
            return fail(line, "after an edge's weight only 'both' may follow");
        }
        if (2 * written_.size() + 2 > WaypointGraph::kMostEdges) {
            return fail(line, "too many edges");
        }
        e.edge = {*from, *to, *weight};
        e.both = !last.empty();
        written_.push_back(e);
        return true;
    }

    bool take(const WrittenEdge& e, std::vector<WaypointEdge>& edges) {
        const auto from = number_.find(e.edge.from);
        const auto to = number_.find(e.edge.to);
        if (from == number_.end() || to == number_.end()) {
            return fail(e.line,
                        "there is no node " +
                            std::to_string(from == number_.end() ? e.edge.from : e.edge.to));
        }
        WaypointEdge edge = e.edge;
        if (e.length) {
            edge.weight =
                (waypoints_[from->second].position - waypoints_[to->second].position).norm();
            if (!std::isfinite(edge.weight)) {
                return fail(e.line, "an edge too long for a weight");
            }
        }
        edges.push_back(edge);
        if (e.both) {
            std::swap(edge.from, edge.to);
            edges.push_back(edge);
        }
        return true;
    }

    std::vector<Waypoint> waypoints_;
    std::unordered_map<std::uint32_t, std::size_t> number_;
    std::vector<WrittenEdge> written_;
    std::string error_;
    int last_line_ = 1;
};

}  // namespace

core::Result<WaypointGraph> parse_waypoints(std::string_view text) {
    return WaypointReader().read(text);
}

}  // namespace zoned::ai::pathfinding
