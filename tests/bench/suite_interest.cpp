// Suite `interest`: which viewers hear of which of 100,000 entities, our matching beside all pairs.
#include "server/interest/matcher.h"
#include "server/spatial/box_lanes.h"
#include "tests/bench/comparison.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

namespace zoned::bench {

namespace {

constexpr float kExtent = 4000.0F;  // m, in both directions
constexpr float kRadius = 60.0F;
/// Different ticks before they come again, backwards.
constexpr std::size_t kMotions = 24;

enum class InterestMotion {
    kNone,
    kAll,   ///< all entities walk: 1.4 m/s at 30 Hz
    kSome,  ///< each tick another 5 %, each of them a step of 0.05 to 3 m
};

struct InterestScene {
    std::string name;
    InterestMotion motion = InterestMotion::kNone;
    bool kept = true;  ///< sets are kept, with their differences; else made anew each tick
};

const std::vector<InterestScene>& interest_scenes() {
    static const std::vector<InterestScene> scenes{
        {"uniform_100k", InterestMotion::kNone, false},
        {"uniform_100k_enter_leave", InterestMotion::kAll, true},
        {"uniform_100k_moving_5pct", InterestMotion::kSome, true}};
    return scenes;
}

/// The entities heard with hysteresis and two levels of detail, as a server has them by default.
interest::InterestSettings interest_settings() {
    interest::InterestSettings settings;
    settings.lod_radius_m = {30.0F};
    return settings;
}

struct Step {
    world::Row row = 0;
    float x = 0.0F;
    float z = 0.0F;
};

/// Entities spread evenly, every tenth a viewer's avatar, and the moved rows of each tick.
class Field {
  public:
    Field(InterestMotion motion, bool quick) : types_(1), motion_(motion) {
        types_[0].aura_m.fill(kRadius);
        types_[0].nimbus_m.fill(kRadius);
        const std::uint32_t size = quick ? 10000 : 100000;
        const float extent = quick ? kExtent / std::sqrt(10.0F) : kExtent;
        core::Rng rng(5);
        for (std::uint32_t i = 1; i <= size; ++i) {
            const world::Row row = entities_.add(EntityId(i), 0);
            entities_.position[row] = Vec3(rng.range(0, extent), 0, rng.range(0, extent));
            if (i % 10 == 0) {
                viewers_.push_back({ClientId(i), EntityId(i)});
            }
        }
        plan(rng);
    }

    /// The next tick: there and back again.
    void move() {
        const std::size_t turn = tick_++ % (2 * kMotions);
        const std::size_t at = turn < kMotions ? turn : 2 * kMotions - 1 - turn;
        if (motion_ == InterestMotion::kAll) {
            // Positions of one tick against those of another: the time to write them is not
            // counted.
            if (turn != kMotions && turn != 0) {
                entities_.position.swap(places_[at]);
                std::swap(places_[at], places_[turn < kMotions ? at - 1 : at + 1]);
            }
        } else if (motion_ == InterestMotion::kSome) {
            const float sign = turn < kMotions ? 1.0F : -1.0F;
            for (const Step& step : steps_[at]) {
                entities_.position[step.row].x() += sign * step.x;
                entities_.position[step.row].z() += sign * step.z;
            }
        }
    }

    [[nodiscard]] const world::Entities& entities() const { return entities_; }

    [[nodiscard]] const world::TypeTable& types() const { return types_; }

    [[nodiscard]] const std::vector<world::Viewer>& viewers() const { return viewers_; }

  private:
    static Step step_of(core::Rng& rng, world::Row row, float length) {
        const float turn = rng.range(0, 2.0F * std::numbers::pi_v<float>);
        return {row, length * std::cos(turn), length * std::sin(turn)};
    }

    void plan(core::Rng& rng) {
        const auto size = static_cast<std::uint32_t>(entities_.size());
        if (motion_ == InterestMotion::kAll) {
            std::vector<Step> walk;
            for (world::Row row = 0; row < size; ++row) {
                walk.push_back(step_of(rng, row, 1.4F / 30.0F));
            }
            for (std::size_t k = 0; k < kMotions; ++k) {
                places_.push_back(entities_.position);
                for (const Step& step : walk) {
                    places_[k][step.row].x() += static_cast<float>(k) * step.x;
                    places_[k][step.row].z() += static_cast<float>(k) * step.z;
                }
            }
        } else if (motion_ == InterestMotion::kSome) {
            steps_.resize(kMotions);
            for (std::vector<Step>& steps : steps_) {
                // One in twenty, of avatars and of others alike.
                for (std::uint32_t first = 0; first < size; first += 20) {
                    const world::Row row = first + rng.below(20);
                    steps.push_back(step_of(rng, row, rng.range(0.05F, 3.0F)));
                }
            }
        }
    }

    world::Entities entities_;
    world::TypeTable types_;
    std::vector<world::Viewer> viewers_;
    InterestMotion motion_;
    std::vector<std::vector<Vec3>> places_;
    std::vector<std::vector<Step>> steps_;
    std::size_t tick_ = 0;
};

/// All pairs, eight at a time, by the rule alone; remembers the known entities by row.
class AllPairs {
  public:
    /// Without memory: rows within the radii, ascending.
    void match(const Field& field, std::size_t viewer, float widen) {
        const world::Row own = field.entities().find(field.viewers()[viewer].avatar);
        const float r = kRadius * widen;
        rows_.clear();
        for (std::size_t i = 0; i + spatial::kLanes <= x_.size(); i += spatial::kLanes) {
            const Array8 dx = Array8::load(&x_[i]) - x_[own];
            const Array8 dz = Array8::load(&z_[i]) - z_[own];
            std::uint32_t mask = spatial::lanes_at_most(dx * dx + dz * dz, r * r);
            for (; mask != 0; mask &= mask - 1) {
                const auto row =
                    static_cast<world::Row>(i + static_cast<std::size_t>(std::countr_zero(mask)));
                if (row != own) {
                    rows_.push_back(row);
                }
            }
        }
    }

    void read(const Field& field) {
        const std::vector<Vec3>& p = field.entities().position;
        x_.resize(p.size());
        z_.resize(p.size());
        for (std::size_t i = 0; i < p.size(); ++i) {
            x_[i] = p[i].x();
            z_[i] = p[i].z();
        }
    }

    /// With memory: the entities that the viewer should know after this tick. Entities have the ids
    /// of their rows, plus one.
    void follow(const Field& field,
                std::size_t viewer,
                const interest::InterestSettings& settings) {
        known_.resize(field.viewers().size());
        match(field, viewer, 1.0F + settings.hysteresis);
        const world::Row own = field.entities().find(field.viewers()[viewer].avatar);
        std::vector<world::Visible>& known = known_[viewer];
        next_.clear();
        auto old = known.begin();
        for (const world::Row row : rows_) {
            const EntityId entity = field.entities().id[row];
            while (old != known.end() && old->entity < entity) {
                ++old;
            }
            const bool was = old != known.end() && old->entity == entity;
            const float dx = x_[row] - x_[own];
            const float dz = z_[row] - z_[own];
            const float d2 = dx * dx + dz * dz;
            if (interest::hears(d2, kRadius, kRadius, was, settings.hysteresis)) {
                next_.push_back(
                    {entity, interest::lod_at(std::sqrt(d2), settings, was ? old->lod : -1)});
            }
        }
        known.assign(next_.begin(), next_.end());
    }

    [[nodiscard]] const std::vector<world::Row>& rows() const { return rows_; }

    [[nodiscard]] const std::vector<world::Visible>& known(std::size_t viewer) const {
        return known_[viewer];
    }

  private:
    std::vector<float> x_;
    std::vector<float> z_;
    std::vector<world::Row> rows_;
    std::vector<world::Visible> next_;
    std::vector<std::vector<world::Visible>> known_;
};

/// Pairs in one list and not in the other, both ascending by entity.
std::size_t pairs_that_differ(const std::vector<world::Visible>& a,
                              const std::vector<world::Visible>& b) {
    std::size_t differ = 0;
    auto i = a.begin();
    auto j = b.begin();
    while (i != a.end() || j != b.end()) {
        if (j == b.end() || (i != a.end() && i->entity < j->entity)) {
            ++differ;
            ++i;
        } else if (i == a.end() || j->entity < i->entity) {
            ++differ;
            ++j;
        } else {
            differ += i->lod != j->lod ? 1U : 0U;
            ++i;
            ++j;
        }
    }
    return differ;
}

class InterestTrial : public JudgedTrial {
  public:
    InterestTrial(const InterestScene& scene, bool quick)
        : scene_(scene),
          settings_(interest_settings()),
          field_(scene.motion, quick) {}

    void judge(Row& row) override {
        row.error = static_cast<double>(wrong_);
        row.error_unit = std::string("pairs");
        row.metric("pairs_compared", static_cast<double>(compared_));
        row.metric("pairs", static_cast<double>(pairs_));
        row.metric("viewers", static_cast<double>(field_.viewers().size()));
        row.metric("entities", static_cast<double>(field_.entities().size()));
        row.metric("entered_and_left_per_tick", ticks_ > 1.0 ? differences_ / (ticks_ - 1.0) : 0.0);
    }

  protected:
    void compare_sets(const world::Visibility& sets) {
        truth_.read(field_);
        pairs_ = 0;
        for (std::size_t i = 0; i < sets.size(); ++i) {
            truth_.follow(field_, i, settings_);
            wrong_ += pairs_that_differ(sets[i].visible, truth_.known(i));
            pairs_ += sets[i].visible.size();
            differences_ += ticks_ > 0.0
                                ? static_cast<double>(sets[i].entered.size() + sets[i].left.size())
                                : 0.0;
        }
        compared_ += pairs_;
        ++ticks_;
    }

    InterestScene scene_;
    interest::InterestSettings settings_;
    Field field_;
    AllPairs truth_;
    std::size_t wrong_ = 0;
    std::size_t compared_ = 0;
    std::size_t pairs_ = 0;
    double ticks_ = 0.0;
    double differences_ = 0.0;
};

class MatcherTrial final : public InterestTrial {
  public:
    using InterestTrial::InterestTrial;

    void frame() override {
        field_.move();
        if (!scene_.kept) {
            matcher_ = interest::Matcher();
            visibility_.clear();
        }
        report_ = matcher_.step(
            field_.entities(), field_.types(), field_.viewers(), settings_, visibility_);
    }

    void observe() override { compare_sets(visibility_); }

    void judge(Row& row) override {
        InterestTrial::judge(row);
        row.metric("pairs_examined_per_tick", report_.examined);
        row.metric("sets_refreshed_per_tick", report_.refreshed);
    }

  private:
    interest::Matcher matcher_;
    interest::InterestReport report_;
    world::Visibility visibility_;
};

class AllPairsTrial final : public InterestTrial {
  public:
    using InterestTrial::InterestTrial;

    void frame() override {
        field_.move();
        all_.read(field_);
        pairs_ = 0;
        for (std::size_t i = 0; i < field_.viewers().size(); ++i) {
            if (scene_.kept) {
                all_.follow(field_, i, settings_);
                pairs_ += all_.known(i).size();
            } else {
                all_.match(field_, i, 1.0F);
                pairs_ += all_.rows().size();
            }
        }
    }

    void observe() override { compared_ += pairs_; }

  private:
    AllPairs all_;
};

void run_interest_scene(Session& session, const InterestScene& scene) {
    session.progress("interest " + scene.name);
    const bool quick = session.quick;
    const std::vector<Method> ours{{"default", "", [&scene, quick] {
                                        return std::make_unique<MatcherTrial>(scene, quick);
                                    }}};
    const std::vector<Method> theirs{{"all", "brute_force", [&scene, quick] {
                                          return std::make_unique<AllPairsTrial>(scene, quick);
                                      }}};
    const int repeats = quick ? 1 : session.repeats;
    const auto run = [&](const std::vector<Method>& methods, const Plan& plan) {
        const std::vector<Method> asked = wanted(session, methods);
        if (!asked.empty()) {
            session.add(compare("interest", scene.name, "", asked, plan));
        }
    };
    run(ours, {4, quick ? 8 : 2 * static_cast<int>(kMotions), repeats});
    run(theirs, {0, 2, 1});
}

void run_interest(Session& session) {
    session.note(
        "interest: 10,000 viewers among 100,000 entities on 4 x 4 km, radius 60 m, one thread; "
        "uniform_100k: all sets from nothing, as when a zone starts; all: sets with hysteresis "
        "0.1, two "
        "levels of detail and lists of what entered and left. enter_leave: all walk, 1.4 m/s at "
        "30 Hz; moving_5pct: each tick another 5 % step 0.05 to 3 m, avatars alike (writing their "
        "places is timed as well)");
    for (const InterestScene& scene : interest_scenes()) {
        if (session.wants_scene(scene.name)) {
            run_interest_scene(session, scene);
        }
    }
}

const Registration kInterest(
    {"interest",
     "who hears of what among 100,000 entities: time, and pairs that differ from all pairs",
     {"uniform_100k", "uniform_100k_enter_leave", "uniform_100k_moving_5pct"},
     {"default", "brute_force/all"},
     run_interest});

}  // namespace

}  // namespace zoned::bench
