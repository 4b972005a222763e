#include "server/ai/steering/formation_following.h"

#include "shared/math/heading.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace zoned::ai {

namespace {

/// A captain that is slower than this looks where it faces, m/s.
constexpr float kStands = 0.3F;
/// While a member straggles slots are assigned anew every this many ticks.
constexpr Tick kRegroup = 32;
/// A member that wants less than this share of its speed stands.
constexpr float kRankStands = 0.08F;
/// Speeds that differ by this share are worth a new command, and so are directions beyond the
/// cosine: cos 8 degrees.
constexpr float kRankPace = 0.12F;
constexpr float kRankCos = 0.99027F;

Vec2 ground_of(const Vec3& v) {
    return {v.x(), v.z()};
}

Vec2 heading_of_captain(const world::Entities& entities, world::Row row) {
    const Vec2 velocity = ground_of(entities.velocity[row]);
    const float speed = velocity.norm();
    return speed > kStands ? Vec2(velocity / speed) : heading_of(entities.yaw[row]);
}

/// The place of slot `index` of `members` (> index) beside the captain, m.
steering::FormationSlot slot_in(const FormationDef& def, std::size_t index, std::size_t members) {
    const float gap = def.spacing_m;
    const auto centred = [gap](std::size_t column, std::size_t columns) {
        return gap * (static_cast<float>(column) - 0.5F * static_cast<float>(columns - 1));
    };
    switch (def.shape) {
        case FormationShape::kRows: {
            const std::size_t columns = def.columns;
            const std::size_t row = index / columns;
            // The last row is as wide as there are left.
            const std::size_t in_row = std::min(columns, members - row * columns);
            return {-gap * static_cast<float>(row + 1), centred(index % columns, in_row)};
        }
        case FormationShape::kWedge: {
            std::size_t row = 0;
            std::size_t first = 0;
            while (index >= first + row + 2) {
                first += row + 2;
                ++row;
            }
            return {-gap * static_cast<float>(row + 1), centred(index - first, row + 2)};
        }
        case FormationShape::kRing: {
            const auto turn = static_cast<std::uint16_t>((index * 65536U) / members);
            const Vec2 direction = heading_of(turn);
            // Neighbours on the ring are `gap` apart along it.
            const float radius = std::max(
                gap, gap * static_cast<float>(members) / (2.0F * std::numbers::pi_v<float>));
            return {radius * direction.y(), radius * direction.x()};
        }
    }
    return {};
}

}  // namespace

/// Rows of other zones whose agents may form up: members of a company that is on both sides of a
/// border are among them.
std::size_t ghosts_in_formations(const world::Entities& entities,
                                 const world::TypeTable& types,
                                 std::span<const CompiledBrain> brains) {
    std::size_t ghosts = 0;
    for (world::Row row = 0; row < entities.size(); ++row) {
        const std::uint16_t agent = types[entities.type[row]].brain;
        ghosts += entities.has(row, world::kGhost) && agent != 0 && agent <= brains.size() &&
                          brains[agent - 1U].forms_up
                      ? 1
                      : 0;
    }
    return ghosts;
}

/// Members of one captain that do the same.
struct Formations::Group {
    std::span<const Rank> ranks;
    const FormationDef* def;
    Vec2 centre;
    Vec2 heading;
    bool regroups;        ///< present members close the gaps of missing ones
    std::size_t company;  ///< how many there are, on both sides of a border

    [[nodiscard]] Vec2 offset(std::size_t index) const {
        const steering::FormationSlot slot = slot_in(*def, index, company);
        return slot.ahead * heading + slot.right * Vec2(-heading.y(), heading.x());
    }
};

void Formations::give_slots(AgentStore& agents,
                            const world::Entities& entities,
                            const Group& group) {
    const std::size_t count = std::min(group.ranks.size(), kMostInFormation);
    taken_.assign(group.company, 0);
    bool whole = true;
    bool strays = false;
    for (std::size_t i = 0; i < count && whole; ++i) {
        const std::uint8_t corner = agents.at(group.ranks[i].slot).corner;
        const std::size_t slot = corner & ~kStraggles;
        strays = strays || (corner & kStraggles) != 0;
        whole = slot < group.company && taken_[slot] == 0;
        if (whole) {
            taken_[slot] = 1;
        }
    }
    const bool together = count == group.company;
    if (!whole || (strays && group.regroups && together)) {
        cost_.clear();
        for (std::size_t i = 0; i < count; ++i) {
            const Vec2 at = ground_of(entities.position[group.ranks[i].row]);
            for (std::size_t slot = 0; slot < group.company; ++slot) {
                const Vec2 path = group.centre + group.offset(slot) - at;
                cost_.push_back(static_cast<double>(path.squaredNorm()));
            }
        }
        const auto slots = assignment_.solve(cost_, count, group.company);
        for (std::size_t i = 0; i < count; ++i) {
            std::uint8_t& corner = agents.at(group.ranks[i].slot).corner;
            corner = static_cast<std::uint8_t>((corner & kStraggles) | slots[i]);
            agents.at(group.ranks[i].slot).steps = static_cast<std::uint16_t>(group.company);
        }
    }
    for (std::size_t i = count; i < group.ranks.size(); ++i) {
        agents.at(group.ranks[i].slot).corner |= kNoRank;
    }
}

/// The size of a company. It is the number of members here, unless they were more when they got
/// their slots and the rest may be among the ghosts.
template <class Ghosts>
std::size_t Formations::company_of(std::span<const Rank> ranks,
                                   const AgentStore& agents,
                                   Ghosts&& ghosts) {
    const std::size_t here = std::min(ranks.size(), kMostInFormation);
    std::size_t were = 0;
    for (const Rank& rank : ranks) {
        were = std::max<std::size_t>(were, agents.at(rank.slot).steps);
    }
    return were > here && were <= kMostInFormation && ghosts() >= were - here ? were : here;
}

void Formations::place(AgentStore& agents,
                       const world::Entities& entities,
                       const world::TypeTable& types,
                       std::span<const CompiledBrain> brains,
                       const steering::Walls& walls,
                       Tick now) {
    const auto def_of = [&](const Rank& rank) {
        const Agent& agent = agents.at(rank.slot);
        return &*brains[agent.brain].states[agent.current_action].formation;
    };
    // The search is made once, and only where a member is missing.
    auto ghosts = [&, found = std::optional<std::size_t>()]() mutable {
        if (!found) {
            found = ghosts_in_formations(entities, types, brains);
        }
        return *found;
    };
    std::sort(ranks_.begin(), ranks_.end(), [](const Rank& a, const Rank& b) {
        return a.captain != b.captain ? a.captain < b.captain : a.entity < b.entity;
    });
    for (std::size_t begin = 0; begin < ranks_.size();) {
        std::size_t end = begin + 1;
        while (end < ranks_.size() && ranks_[end].captain == ranks_[begin].captain) {
            ++end;
        }
        const world::Row captain = ranks_[begin].captain_row;
        const auto ranks = std::span<const Rank>(ranks_).subspan(begin, end - begin);
        const Group group{ranks,
                          def_of(ranks_[begin]),
                          ground_of(entities.position[captain]),
                          heading_of_captain(entities, captain),
                          (now + static_cast<Tick>(ranks_[begin].captain.value)) % kRegroup == 0,
                          company_of(ranks, agents, ghosts)};
        give_slots(agents, entities, group);
        for (const Rank& rank : group.ranks) {
            Agent& agent = agents.at(rank.slot);
            const std::size_t slot = agent.corner & ~kStraggles;
            const Vec2 offset = slot == kNoRank ? Vec2(Vec2::Zero()) : group.offset(slot);
            const float radius = types[entities.type[rank.row]].character.radius;
            const Vec2 place = steering::slot_before_walls(group.centre, offset, radius, walls);
            const Vec2 at = ground_of(entities.position[rank.row]);
            const float distance = (place - at).norm();
            const bool sees = steering::free_share(at, place, walls) >= 1.0F;
            const steering::FormationSettings& settings = group.def->settings;
            const bool stray = straggles(agent) ? distance > settings.taken_back_m || !sees
                                                : distance > settings.straggler_m || !sees;
            agent.corner = static_cast<std::uint8_t>(slot | (stray ? kStraggles : 0U));
            // A member separated from its place by a wall follows the captain, who came by some
            // path.
            const Vec2 to = sees ? place : group.centre;
            agent.target = Vec3(to.x(), entities.position[rank.row].y(), to.y());
        }
        begin = end;
    }
}

void steer_in_formation(Agent& agent,
                        const BrainState& state,
                        bool entered,
                        const Surroundings& around) {
    const world::Entities& e = around.ai.entities;
    const world::Row captain = agent.ward ? e.find(agent.ward) : world::kNoRow;
    const motion::CharacterLimits& limits = around.ai.types[e.type[around.self]].character;
    const float full = std::max(0.01F, full_speed(state, around));
    Vec2 want = Vec2::Zero();
    if (captain != world::kNoRow && !e.has(captain, world::kHidden)) {
        want = steering::pull_to_slot(state.formation->settings,
                                      ground_of(e.velocity[captain]),
                                      ground_of(agent.target) - around.body());
    }
    const float speed = std::min(want.norm(), full);
    agent.next_steering = around.ai.now + 1;
    restart_progress(agent, e.position[around.self], around.ai.now);
    const bool stood = !moving(agent);
    if (!(speed >= (stood ? 2.0F : 1.0F) * kRankStands * full)) {
        agent.aim = motion::InputCommand{};
        agent.aim.yaw = e.yaw[around.self];
        return;
    }
    const Vec2 direction = want.normalized();
    const float top = limits.speed * (state.sprint ? limits.sprint_factor : 1.0F);
    const float aimed = Vec2(agent.aim.move_x, agent.aim.move_z).norm() / kFullMove;
    const float share = speed / top;
    if (entered || stood || aim_direction(agent).dot(direction) < kRankCos ||
        std::abs(aimed - share) > kRankPace * full / top) {
        aim_along(agent, Pace{share, state.sprint}, direction);
    }
}

}  // namespace zoned::ai
