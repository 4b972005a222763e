#include "server/ai/pathfinding/waypoints/waypoint_graph.h"
#include "shared/core/files/line_reader.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <unordered_map>

namespace zoned::ai::pathfinding {

namespace {

struct WrittenEdge {
    WaypointEdge edge;
    bool length = false;  ///< its weight is its length
    bool both = false;
    std::size_t line = 0;
};

class WaypointReader {
  public:
    core::Result<WaypointGraph> read(std::string_view text) {
        core::LineReader in(text, '#');
        while (!in.failed() && in.next_written()) {
            read_line(in);
        }
        std::vector<WaypointEdge> edges;
        for (const WrittenEdge& e : written_) {
            if (!in.failed()) {
                take(in, e, edges);
            }
        }
        if (in.failed()) {
            return core::Result<WaypointGraph>::failure(in.error());
        }
        auto graph = WaypointGraph::build(waypoints_, edges);
        if (!graph) {
            in.fail(graph.error());
            return core::Result<WaypointGraph>::failure(in.error());
        }
        return graph;
    }

  private:
    void read_line(core::LineReader& in) {
        const std::string_view kind = in.word();
        if (kind == "node") {
            read_node(in);
        } else if (kind == "edge") {
            read_edge(in);
        } else {
            in.fail("a line begins with node or edge");
        }
    }

    bool read_node(core::LineReader& in) {
        const auto id = in.number<std::uint32_t>();
        const auto x = in.number<float>();
        const auto y = in.number<float>();
        const auto z = in.number<float>();
        if (!id || !x || !y || !z || !std::isfinite(*x) || !std::isfinite(*y) ||
            !std::isfinite(*z)) {
            return in.fail("expected: node ID X Y Z [blocked]");
        }
        const std::string_view last = in.word();
        if ((!last.empty() && last != "blocked") || !in.word().empty()) {
            return in.fail("after a node's place only 'blocked' may follow");
        }
        if (waypoints_.size() == WaypointGraph::kMostWaypoints) {
            return in.fail("too many nodes");
        }
        if (!number_.try_emplace(*id, waypoints_.size()).second) {
            return in.fail("node " + std::to_string(*id) + " is given twice");
        }
        waypoints_.push_back({*id, Vec3(*x, *y, *z), last.empty()});
        return true;
    }

    bool read_edge(core::LineReader& in) {
        WrittenEdge e;
        e.line = in.line();
        const auto from = in.number<std::uint32_t>();
        const auto to = in.number<std::uint32_t>();
        const std::string_view written = in.word();
        e.length = written == "length";
        const auto weight =
            e.length ? std::optional<float>(0.0F) : core::parse_number<float>(written);
        if (!from || !to || !weight) {
            return in.fail("expected: edge FROM TO WEIGHT [both]");
        }
        if (!(*weight >= 0.0F) || !std::isfinite(*weight)) {
            return in.fail("a weight is 0 or more");
        }
        const std::string_view last = in.word();
        if ((!last.empty() && last != "both") || !in.word().empty()) {
            return in.fail("after an edge's weight only 'both' may follow");
        }
        if (2 * written_.size() + 2 > WaypointGraph::kMostEdges) {
            return in.fail("too many edges");
        }
        e.edge = {*from, *to, *weight};
        e.both = !last.empty();
        written_.push_back(e);
        return true;
    }

    bool take(core::LineReader& in, const WrittenEdge& e, std::vector<WaypointEdge>& edges) {
        const auto from = number_.find(e.edge.from);
        const auto to = number_.find(e.edge.to);
        if (from == number_.end() || to == number_.end()) {
            return in.fail_at(e.line,
                              "there is no node " +
                                  std::to_string(from == number_.end() ? e.edge.from : e.edge.to));
        }
        WaypointEdge edge = e.edge;
        if (e.length) {
            edge.weight =
                (waypoints_[from->second].position - waypoints_[to->second].position).norm();
            if (!std::isfinite(edge.weight)) {
                return in.fail_at(e.line, "an edge too long for a weight");
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
};

}  // namespace

core::Result<WaypointGraph> parse_waypoints(std::string_view text) {
    return WaypointReader().read(text);
}

}  // namespace zoned::ai::pathfinding
