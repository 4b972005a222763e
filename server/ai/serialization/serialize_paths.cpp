#include "server/ai/serialization/serialize_paths.h"

#include "shared/core/archive/field_archive.h"

#include <bit>

namespace zoned::ai {

namespace {

using core::FieldReader;
using core::FieldWriter;

using pathfinding::Hinge;
using pathfinding::PathEnd;
using pathfinding::SavedField;
using pathfinding::SavedPaths;
using pathfinding::SavedPortalCosts;
using pathfinding::SavedPortalRow;
using pathfinding::SavedRequest;
using pathfinding::SavedTable;
using pathfinding::SavedTurn;
using pathfinding::Spot;

constexpr std::uint32_t kPathVersion = 5;

void write_count(std::size_t count, FieldWriter& write) {
    write(static_cast<std::uint32_t>(count));
}

/// Reads elements one by one, at most as many as the bytes can hold.
template <class Element, class ReadElement>
void read_list(std::vector<Element>& list, FieldReader& read, const ReadElement& read_element) {
    std::uint32_t count = 0;
    read(count);
    for (std::uint32_t i = 0; i < count && !read.cut_short(); ++i) {
        read_element(list.emplace_back());
    }
}

void write_numbers(const std::vector<std::uint32_t>& numbers, FieldWriter& write) {
    write_count(numbers.size(), write);
    for (const std::uint32_t number : numbers) {
        write(number);
    }
}

void read_numbers(std::vector<std::uint32_t>& numbers, FieldReader& read) {
    read_list(numbers, read, [&](std::uint32_t& number) { read(number); });
}

/// Writes a height, which may be NaN for none.
void write_height(float metres, FieldWriter& write) {
    write(std::bit_cast<std::uint32_t>(metres));
}

void read_height(float& metres, FieldReader& read) {
    std::uint32_t bits = 0;
    read(bits);
    metres = std::bit_cast<float>(bits);
}

void write_end(const PathEnd& end, FieldWriter& write) {
    for (const Vec3& v : {end.wanted, end.on}) {
        write(v.x());
        write_height(v.y(), write);
        write(v.z());
    }
    write(end.node);
}

void read_end(PathEnd& end, FieldReader& read) {
    for (Vec3* const v : {&end.wanted, &end.on}) {
        read(v->x());
        read_height(v->y(), read);
        read(v->z());
    }
    read(end.node);
}

/// Visits all fields of a request that are one number.
template <class RequestOf, class Visit>
void visit_numbers(RequestOf& r, Visit& visit) {
    visit(r.number);
    visit(r.round);
    visit(r.asker);
    visit(r.taken);
    visit(r.waiting);
    visit(r.usable);
    visit(r.best);
    visit(r.doubted);
    visit(r.reaches);
    visit(r.outcome);
    visit(r.next);
    visit(r.length_m);
    visit(r.rest_m);
    visit(r.cost);
    visit(r.short_m);
    visit(r.last);
}

void write_request(const SavedRequest& r, FieldWriter& write) {
    visit_numbers(r, write);
    write_end(r.from, write);
    write_end(r.to, write);
    write_count(r.corners.size(), write);
    for (const Spot& s : r.corners) {
        write(s.x);
        write(s.z);
    }
    write_count(r.hinges.size(), write);
    for (const Hinge& h : r.hinges) {
        write(h.what);
        write(h.corner);
    }
}

void read_request(SavedRequest& r, FieldReader& read) {
    visit_numbers(r, read);
    read_end(r.from, read);
    read_end(r.to, read);
    read_list(r.corners, read, [&](Spot& s) {
        read(s.x);
        read(s.z);
    });
    read_list(r.hinges, read, [&](Hinge& h) {
        read(h.what);
        read(h.corner);
    });
}

/// Visits all fields of a crowd's saved state that are one number.
template <class CrowdOf, class Visit>
void visit_crowd(CrowdOf& crowd, Visit& visit) {
    visit(crowd.ticks);
    visit(crowd.tick);
    visit(crowd.round);
    visit(crowd.reviewed_round);
    visit(crowd.next_review);
}

template <class BlockOf, class Visit>
void visit_block(BlockOf& block, Visit& visit) {
    visit(block.block);
    visit(block.density);
    visit(block.crowding);
}

template <class GoalOf, class Visit>
void visit_goal(GoalOf& goal, Visit& visit) {
    visit(goal.place);
    visit(goal.used);
    visit(goal.answers);
}

void write_crowd(const pathfinding::SavedCrowds& crowd, FieldWriter& write) {
    visit_crowd(crowd, write);
    write_count(crowd.blocks.size(), write);
    for (const auto& block : crowd.blocks) {
        visit_block(block, write);
    }
    write_count(crowd.goals.size(), write);
    for (const auto& goal : crowd.goals) {
        visit_goal(goal, write);
    }
}

void read_crowd(pathfinding::SavedCrowds& crowd, FieldReader& read) {
    visit_crowd(crowd, read);
    read_list(crowd.blocks, read, [&](auto& block) { visit_block(block, read); });
    read_list(crowd.goals, read, [&](auto& goal) { visit_goal(goal, read); });
}

void write_portal_costs(const SavedPortalCosts& costs, FieldWriter& write) {
    write_count(costs.rows.size(), write);
    for (const SavedPortalRow& row : costs.rows) {
        write(row.portal);
        write_numbers(row.costs, write);
    }
    write_numbers(costs.wanted, write);
    write(costs.spread);
}

void read_portal_costs(SavedPortalCosts& costs, FieldReader& read) {
    read_list(costs.rows, read, [&](SavedPortalRow& row) {
        read(row.portal);
        read_numbers(row.costs, read);
    });
    read_numbers(costs.wanted, read);
    read(costs.spread);
}

void write_map(const SavedPaths& map, FieldWriter& write) {
    write_count(map.requests.size(), write);
    for (const SavedRequest& r : map.requests) {
        write_request(r, write);
    }
    write_numbers(map.free, write);
    write_numbers(map.free_rounds, write);
    write_count(map.turns.size(), write);
    for (const SavedTurn& turn : map.turns) {
        write(turn.asker);
        write(turn.waited_ticks);
        write_numbers(turn.requests, write);
    }
    write_numbers(map.unled, write);
    write_count(map.fields.size(), write);
    for (const SavedField& field : map.fields) {
        write(field.goal);
        write(field.used);
    }
    write_count(map.tables.size(), write);
    for (const SavedTable& table : map.tables) {
        write(table.node);
        write(table.used);
    }
    write_portal_costs(map.portal_costs, write);
    write(map.tick);
    write(map.typical_work);
    write(map.cheap_work);
    write(map.index_given);
    write(map.searched_work);
    write_crowd(map.crowd, write);
}

void read_map(SavedPaths& map, FieldReader& read) {
    read_list(map.requests, read, [&](SavedRequest& r) { read_request(r, read); });
    read_numbers(map.free, read);
    read_numbers(map.free_rounds, read);
    read_list(map.turns, read, [&](SavedTurn& turn) {
        read(turn.asker);
        read(turn.waited_ticks);
        read_numbers(turn.requests, read);
    });
    read_numbers(map.unled, read);
    read_list(map.fields, read, [&](SavedField& field) {
        read(field.goal);
        read(field.used);
    });
    read_list(map.tables, read, [&](SavedTable& table) {
        read(table.node);
        read(table.used);
    });
    read_portal_costs(map.portal_costs, read);
    read(map.tick);
    read(map.typical_work);
    read(map.cheap_work);
    read(map.index_given);
    read(map.searched_work);
    read_crowd(map.crowd, read);
}

/// Visits the fields of one requester.
template <class AskedOf, class Visit>
void visit_asked(AskedOf& asked, Visit& visit) {
    visit(asked.entity.value);
    visit(asked.ticket.slot);
    visit(asked.ticket.round);
    visit(asked.size);
    visit(asked.beyond);
    visit(asked.rough);
    visit(asked.goal.x);
    visit(asked.goal.z);
}

}  // namespace

bool serialize_paths(const PathService& paths, std::vector<std::uint8_t>& out) {
    FieldWriter write(out);
    write(kPathVersion);
    const SavedPathService memory = paths.save();
    write_count(memory.asked.size(), write);
    for (const SavedPathService::Asked& asked : memory.asked) {
        visit_asked(asked, write);
    }
    write_count(memory.sizes.size(), write);
    bool whole = true;
    for (const SavedPaths& map : memory.sizes) {
        write_map(map, write);
        whole = whole && map.whole;
    }
    return whole;
}

std::string deserialize_paths(std::span<const std::uint8_t> bytes,
                              const AgentStore& agents,
                              PathService& paths,
                              AiUpdate& step) {
    FieldReader read(bytes);
    std::uint32_t version = 0;
    read(version);
    if (read.cut_short() || version != kPathVersion) {
        return "version " + std::to_string(version) + " of paths, not " +
               std::to_string(kPathVersion);
    }
    SavedPathService memory;
    read_list(
        memory.asked, read, [&](SavedPathService::Asked& asked) { visit_asked(asked, read); });
    read_list(memory.sizes, read, [&](SavedPaths& map) { read_map(map, read); });
    if (read.cut_short()) {
        return "paths are cut short";
    }
    if (!read.finite() || !read.known()) {
        return "paths have a number that is none";
    }
    if (read.left() > 0) {
        return std::to_string(read.left()) + " bytes are left over";
    }
    std::string wrong = paths.load(memory, [&agents](EntityId entity) -> std::optional<Slot> {
        return agents.find(entity) != nullptr ? std::optional(agents.slot_of(entity))
                                              : std::nullopt;
    });
    if (wrong.empty()) {
        step.wait_for(paths, agents);
    }
    return wrong;
}

}  // namespace zoned::ai
