#include "server/ai/pathfinding/requests/grid_path_requests.h"

#include <algorithm>

namespace zoned::ai::pathfinding {

SavedRequest GridPathRequests::saved_request(std::uint32_t number) const {
    const RequestSlot& slot = slots_[number];
    const GridMap& map = planner_.map();
    SavedRequest m;
    m.number = number;
    m.round = slot.round;
    m.asker = slot.asker;
    m.taken = slot.taken;
    m.waiting = slot.waiting;
    if (!slot.taken) {
        return m;
    }
    // Off the map there are no cells.
    const bool placed = slot.outcome != PathOutcome::kOffMap;
    m.from = {Vec3(slot.at.x, 0.0F, slot.at.z), Vec3::Zero(), placed ? map.place(slot.start) : ~0U};
    m.to = {Vec3(slot.to.x, 0.0F, slot.to.z), Vec3::Zero(), placed ? map.place(slot.goal) : ~0U};
    m.usable = slot.usable;
    m.best = slot.best;
    m.doubted = slot.doubted;
    m.reaches = !slot.moved;
    m.outcome = slot.outcome;
    m.next = slot.next;
    m.length_m = slot.length_m;
    m.rest_m = slot.rest_m;
    const std::span<const Spot> corners = pool_.of(slot.corners);
    m.corners.assign(corners.begin(), corners.end());
    return m;
}

bool GridPathRequests::settled() const {
    return !renewing_ && regions_.settled() && building_ == kNoPlace && to_queue_.empty() &&
           (crowd_ == nullptr || !crowd_->busy());
}

SavedPaths GridPathRequests::save() const {
    SavedPaths memory;
    memory.free = free_;
    for (const std::uint32_t number : free_) {
        memory.free_rounds.push_back(slots_[number].round);
    }
    for (std::uint32_t i = 0; i < slots_.size(); ++i) {
        if (slots_[i].taken || slots_[i].waiting) {
            memory.requests.push_back(saved_request(i));
        }
    }
    memory.turns = queue_.turns();
    memory.unled = unled_;
    for (const CachedFlowField& f : fields_) {
        if (f.goal != kNoPlace) {
            memory.fields.push_back({f.goal, f.used});
        }
    }
    regions_.visit_tables([&](Cell goal, std::uint64_t used) {
        memory.tables.push_back({planner_.map().place(goal), used});
    });
    memory.tick = tick_;
    memory.typical_work = typical_work_;
    memory.cheap_work = cheap_work_;
    memory.index_given = index_given_;
    memory.searched_work = searched_work_;
    memory.whole = settled();
    if (crowd_ != nullptr) {
        memory.crowd = crowd_->save();
        memory.crowd.reviewed_round = reviewed_round_;
        memory.crowd.next_review = next_review_;
    }
    return memory;
}

std::string GridPathRequests::defect_of_memory(const SavedPaths& memory) const {
    const GridMap& map = planner_.map();
    std::string wrong = defect_of(memory, {map.places(), 0, settings_.longest_wait_ticks});
    if (!wrong.empty()) {
        return wrong;
    }
    const auto off = [&](std::uint32_t place) {
        return place != ~0U && !map.contains(map.cell(place));
    };
    for (const SavedRequest& m : memory.requests) {
        const bool beside = std::any_of(m.corners.begin(), m.corners.end(), [this](const Spot& s) {
            return !grid_.contains(s);
        });
        const bool asks = m.waiting || m.usable;
        const Spot to{m.to.wanted.x(), m.to.wanted.z()};
        if (m.taken &&
            (off(m.from.node) || off(m.to.node) || beside || (asks && !grid_.contains(to)))) {
            return "path " + std::to_string(m.number) + " leads off the map";
        }
    }
    if (memory.fields.size() > kFields ||
        std::any_of(memory.fields.begin(), memory.fields.end(), [&](const SavedField& f) {
            return off(f.goal);
        })) {
        return "paths remember fields that there are not";
    }
    const auto blocked = [&](const SavedTable& table) {
        return off(table.node) || !map.passable(table.node);
    };
    if (std::any_of(memory.tables.begin(), memory.tables.end(), blocked)) {
        return "paths remember tables that there are not";
    }
    return {};
}

void GridPathRequests::load(const SavedRequest& m) {
    const GridMap& map = planner_.map();
    RequestSlot& slot = slots_[m.number];
    slot.round = m.round;
    slot.asker = m.asker;
    slot.taken = m.taken;
    slot.waiting = m.waiting;
    if (!m.taken) {
        return;
    }
    slot.at = {m.from.wanted.x(), m.from.wanted.z()};
    slot.to = {m.to.wanted.x(), m.to.wanted.z()};
    slot.start = m.from.node != ~0U ? map.cell(m.from.node) : Cell();
    slot.goal = m.to.node != ~0U ? map.cell(m.to.node) : Cell();
    slot.usable = m.usable;
    slot.best = m.best;
    slot.doubted = m.doubted;
    slot.moved = !m.reaches;
    slot.outcome = m.outcome;
    slot.next = m.next;
    slot.length_m = m.length_m;
    slot.rest_m = m.rest_m;
    slot.corners = pool_.take(static_cast<std::uint32_t>(m.corners.size()));
    std::copy(m.corners.begin(), m.corners.end(), pool_.of(slot.corners).begin());
    if (!m.corners.empty()) {
        slot.ahead = m.corners[m.next];
        Cell before = slot.start;
        for (const Spot& corner : m.corners) {
            const Cell after = grid_.cell(corner);
            add_blocks(blocks_[m.number], before, after);
            before = after;
        }
    }
    if (m.waiting) {
        add_wanted(map.place(slot.goal));
        ++counts_.waiting;
    }
}

std::string GridPathRequests::load(const SavedPaths& memory) {
    std::string wrong = defect_of_memory(memory);
    if (!wrong.empty()) {
        return wrong;
    }
    slots_.resize(memory.requests.size() + memory.free.size());
    blocks_.resize(slots_.size());
    free_ = memory.free;
    free_.reserve(slots_.capacity());
    for (std::size_t i = 0; i < free_.size(); ++i) {
        slots_[free_[i]].round = memory.free_rounds[i];
    }
    for (const SavedRequest& m : memory.requests) {
        load(m);
    }
    queue_.load(memory.turns);
    unled_ = memory.unled;
    std::size_t next = 0;
    for (const SavedField& f : memory.fields) {
        builder_.build(planner_.map(), planner_.map().cell(f.goal));
        CachedFlowField& field = fields_[next++];
        builder_.copy_hops(field.hops);
        field.goal = f.goal;
        field.used = f.used;
    }
    regions_.forget_tables();
    for (const SavedTable& table : memory.tables) {
        regions_.prepare(planner_.map(), planner_.map().cell(table.node), {table.used, 0});
    }
    tick_ = memory.tick;
    typical_work_ = memory.typical_work;
    cheap_work_ = memory.cheap_work;
    searched_work_ = memory.searched_work;
    if (memory.index_given != 0 && index_given_ == 0) {
        // Counted work stops at the same place in one go.
        planner_.begin_index(settings_.index);
        indexed_ = planner_.advance_index(memory.index_given);
        index_given_ = memory.index_given;
    }
    if (crowd_ != nullptr) {
        reviewed_round_ = memory.crowd.reviewed_round;
        next_review_ = static_cast<std::size_t>(memory.crowd.next_review);
        if (!crowd_->load(memory.crowd)) {
            return "paths remember crowds where there are none";
        }
    }
    return {};
}

}  // namespace zoned::ai::pathfinding
