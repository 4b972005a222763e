#include "server/ai/offscreen/next_change_forecast.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// Number of decisions whose random numbers are looked at in advance.
constexpr int kLookAhead = 64;

/// The first tick > now at which `becomes(tick)` is true; without rounding, this is `ticks` from
/// now. `becomes` is false at `now`, and once true it stays true. Where rounding delays it, a tick
/// before it.
template <class Becomes>
Tick first_at(Tick now, float ticks, const Becomes& becomes) {
    if (!(ticks < 1e9F)) {
        return kNever;
    }
    constexpr int kFurther = 4;
    Tick at = now + std::max<Tick>(1, static_cast<Tick>(ticks));
    for (int k = 0; k < kFurther && !becomes(at); ++k) {
        ++at;
    }
    // Search downwards in doubling steps, then bisect.
    Tick step = 1;
    Tick no = at - 1;
    while (no > now && becomes(no)) {
        at = no;
        step *= 2;
        no = std::max(now, at - step);
    }
    while (at - no > 1) {
        const Tick middle = no + (at - no) / 2;
        (becomes(middle) ? at : no) = middle;
    }
    return at;
}

float rate_of(const Agent& agent, const CompiledBrain& brain, std::size_t variable) {
    return brain.rates[agent.current_action * brain.variables.size() + variable];
}

bool stock_holds(std::span<const WatchedCondition> watches,
                 const CompiledBrain& brain,
                 const PointsOfInterest& points_of_interest,
                 Tick now) {
    return std::all_of(watches.begin(), watches.end(), [&](const WatchedCondition& watch) {
        const PointOfInterestSense& of =
            brain.points_of_interest[watch.sense - brain.first_poi_sense];
        return holds({watch.sense, watch.compare, watch.threshold},
                     points_of_interest.stock(of.place, static_cast<std::size_t>(of.stock), now));
    });
}

/// Forecasts the state of one agent, clause by clause.
class Forecast {
  public:
    Forecast(const Agent& agent,
             const CompiledBrain& brain,
             const Senses& senses,
             const ForecastInputs& inputs,
             Tick now)
        : agent_(agent),
          brain_(brain),
          senses_(senses),
          step_m_(inputs.speed * inputs.dt),
          day_s_(inputs.day_s),
          period_(decision_period(brain, inputs.dt)),
          now_(now),
          dt_(inputs.dt),
          points_of_interest_(inputs.points_of_interest),
          segment_(inputs.segment) {}

    /// Changes at this tick or later need not be told apart.
    void look_until(Tick tick) { limit_ = tick; }

    /// A tick before which the clause stays as the agent found it, as long as `wait` lasts. Adds
    /// its stock to `wait`.
    [[nodiscard]] Tick change_of(const Clause& clause, StockWait& wait) const {
        const std::span<const WatchedCondition> others = brain_.others(clause);
        const std::span<const WatchedCondition> stock = brain_.on_stock(clause);
        const auto now_holds = [this](const WatchedCondition& watch) {
            return holds_now(watch);
        };
        const bool stock_too = std::all_of(stock.begin(), stock.end(), now_holds);
        const bool whole = stock_too && std::all_of(others.begin(), others.end(), now_holds);
        if (whole != found(clause, whole)) {
            return now_ + 1;
        }
        Tick at = whole ? kNever : now_ + 1;
        for (const WatchedCondition& watch : others) {
            if (whole) {
                at = std::min(at, change_of(watch));
            } else if (at < limit_ && !holds_now(watch)) {
                at = std::max(at, change_of(watch));
            }
        }
        // A clause that time alone keeps false for long needs no stock to be watched.
        if (stock_too != whole || (!whole && at > now_ + period_) || stock.empty()) {
            return at;
        }
        if (clause.stock_number >= StockWait::kMostClauses) {
            return now_ + 1;
        }
        const std::uint32_t bit = 1U << clause.stock_number;
        wait.clauses |= bit;
        wait.held |= whole ? bit : 0U;
        return whole ? at : kNever;
    }

  private:
    [[nodiscard]] float value_of(const WatchedCondition& watch) const {
        return watch.sense < brain_.senses ? senses_[watch.sense] : time_in_state(watch, now_);
    }

    [[nodiscard]] bool holds_now(const WatchedCondition& watch) const {
        return is(watch, value_of(watch));
    }

    static bool is(const WatchedCondition& watch, float value) {
        return holds({watch.sense, watch.compare, watch.threshold}, value);
    }

    /// Whether the agent goes on as if the clause held. An agent that has decided and goes on has
    /// found no transition to hold, except the pending one. A tree's questions count as they are
    /// now; its answer is compared as a whole.
    [[nodiscard]] bool found(const Clause& clause, bool now_holds) const {
        if (clause.transition != state_machine::kNone) {
            return agent_.state_machine.pending == clause.transition;
        }
        return clause.fact < 0 ? now_holds : (agent_.facts >> clause.fact & 1U) != 0;
    }

    /// A tick before which the condition stays as it is.
    [[nodiscard]] Tick change_of(const WatchedCondition& watch) const {
        if (watch.sense >= brain_.senses) {
            return elapsed(watch);
        }
        const float value = senses_[watch.sense];
        switch (watch.sense) {
            case kSensePlayerDistance:
            case kSenseConfidence:
            case kSenseAllies:
            case kSenseFoes:
            case kSenseLeads:
                return kNever;
            case kSenseHomeDistance:
                return passed(watch, Vec2(agent_.home.x(), agent_.home.z()));
            case kSenseRandom:
                return drawn(watch);
            case kSenseTimeOfDay:
                return after((value <= watch.threshold ? watch.threshold : day_s_) - value, dt_);
            default:
                break;
        }
        const std::size_t own = watch.sense - kOwnSenses;
        if (own < brain_.variables.size()) {
            return grown(own, watch);
        }
        if (watch.sense >= brain_.first_poi_sense) {
            const PointOfInterestSense& of =
                brain_.points_of_interest[watch.sense - brain_.first_poi_sense];
            return passed(watch, points_of_interest_.spot(of.place, agent_.entity));
        }
        return fuzzy_changes(watch.sense) ? now_ + 1 : kNever;
    }

    /// Ticks until a value that changes by at most `per_tick` has changed by `amount`, less one
    /// tick for rounding.
    [[nodiscard]] Tick after(float amount, float per_tick) const {
        if (!(per_tick > 0.0F)) {
            return kNever;
        }
        const float ticks = std::floor(amount / per_tick) - 1.0F;
        return ticks < 1e9F ? now_ + std::max<Tick>(1, static_cast<Tick>(ticks)) : kNever;
    }

    /// A tick before which a condition on the distance to `place` (x, z, m) stays as it is.
    [[nodiscard]] Tick passed(const WatchedCondition& watch, const Vec2& place) const {
        const Tick by_speed = after(std::abs(senses_[watch.sense] - watch.threshold), step_m_);
        return segment_ == nullptr
                   ? by_speed
                   : std::max(by_speed, stays_until(*segment_, place, watch.threshold, now_, dt_));
    }

    /// Time in a state, s. It begins at the tick in which the state was entered.
    [[nodiscard]] float time_in_state(const WatchedCondition& watch, Tick at) const {
        const Tick since = agent_.state_machine.since[watch.sense - brain_.senses];
        return static_cast<float>(static_cast<std::int32_t>(at - since)) * dt_;
    }

    [[nodiscard]] Tick elapsed(const WatchedCondition& watch) const {
        const float in_state = time_in_state(watch, now_);
        if (in_state > watch.threshold) {
            return kNever;
        }
        const bool before = is(watch, in_state);
        return first_at(now_, (watch.threshold - in_state) / dt_, [&](Tick at) {
            return is(watch, time_in_state(watch, at)) != before;
        });
    }

    /// Whether a variable has reached its bound.
    [[nodiscard]] bool settled(std::size_t variable) const {
        const float per_tick = rate_of(agent_, brain_, variable);
        const float value = senses_[kOwnSenses + variable];
        const BrainVariable& of = brain_.variables[variable];
        return per_tick == 0.0F || (per_tick > 0.0F ? value >= of.high : value <= of.low);
    }

    [[nodiscard]] Tick grown(std::size_t variable, const WatchedCondition& watch) const {
        const float per_tick = rate_of(agent_, brain_, variable);
        const float value = senses_[kOwnSenses + variable];
        const float way = watch.threshold - value;
        if (settled(variable) || (way != 0.0F && (way > 0.0F) != (per_tick > 0.0F))) {
            return kNever;
        }
        const bool before = is(watch, value);
        return first_at(now_, way / per_tick, [&](Tick at) {
            return is(watch, variable_at(agent_, brain_, variable, at)) != before;
        });
    }

    /// The next decision whose random number changes the condition.
    [[nodiscard]] Tick drawn(const WatchedCondition& watch) const {
        const bool now_is = holds_now(watch);
        Tick at = next_decision(agent_.entity, period_, now_);
        for (int k = 0; k < kLookAhead && at < limit_; ++k, at += period_) {
            if (is(watch, drawn_at(agent_, at)) != now_is) {
                return at;
            }
        }
        return at;
    }

    [[nodiscard]] bool fuzzy_changes(SenseIndex sense) const {
        for (const CompiledBrain::Fuzzy& fuzzy : brain_.fuzzy) {
            if (sense >= fuzzy.first && sense < fuzzy.first + fuzzy.system.outputs()) {
                return std::any_of(fuzzy.inputs.begin(), fuzzy.inputs.end(), [this](SenseIndex in) {
                    return changes(in);
                });
            }
        }
        return true;
    }

    [[nodiscard]] bool changes(SenseIndex sense) const {
        switch (sense) {
            case kSensePlayerDistance:
            case kSenseConfidence:
            case kSenseAllies:
            case kSenseFoes:
            case kSenseLeads:
                return false;
            case kSenseHomeDistance:
                return step_m_ > 0.0F;
            case kSenseRandom:
            case kSenseTimeOfDay:
                return true;
            default:
                return !settled(sense - kOwnSenses);
        }
    }

    const Agent& agent_;
    const CompiledBrain& brain_;
    const Senses& senses_;
    float step_m_;
    float day_s_;
    Tick period_;
    Tick now_;
    Tick limit_ = kNever;
    float dt_;
    const PointsOfInterest& points_of_interest_;
    const PathSegment* segment_;
};

/// Whether the agent's senses and memory would choose its current action.
bool does_as_chosen(const Agent& agent, const CompiledBrain& brain, const Senses& senses) {
    const CompiledBrain::LeafChoice& choice = brain.choices[agent.state_machine.leaf];
    if (choice.tree >= 0) {
        const tree::DecisionTree& tree = brain.trees[static_cast<std::size_t>(choice.tree)];
        const std::span<const float> known(senses.data(), brain.senses);
        return agent.current_action == choice.first + tree.decide(known);
    }
    return choice.plan < 0 || agent.facts != kUnplanned;
}

}  // namespace

NextChange forecast_next_change(const Agent& agent,
                                const CompiledBrain& brain,
                                const Senses& senses,
                                const ForecastInputs& inputs,
                                Tick now) {
    if (brain.code || !does_as_chosen(agent, brain, senses)) {
        return {now + 1};
    }
    Forecast forecast(agent, brain, senses, inputs, now);
    const state_machine::FlatTransition* const pending =
        agent.state_machine.pending != state_machine::kNone
            ? &brain.table.transitions[agent.state_machine.pending]
            : nullptr;
    NextChange next_change;
    bool is_held = false;
    for (const Clause& clause : brain.clauses_of(agent.state_machine.leaf)) {
        const bool transition = clause.transition != state_machine::kNone;
        // Of the transitions with a hold, the first that holds counts.
        if (is_held && transition && brain.table.transitions[clause.transition].hold > 0) {
            continue;
        }
        forecast.look_until(next_change.until);
        next_change.until =
            std::min(next_change.until, forecast.change_of(clause, next_change.wait));
        is_held = is_held || (transition && clause.transition == agent.state_machine.pending);
        if (next_change.until <= now + 1) {
            return {now + 1};
        }
    }
    if (pending != nullptr) {
        next_change.until =
            std::min(next_change.until, agent.state_machine.pending_since + pending->hold);
    }
    next_change.until = std::max(next_change.until, now + 1);
    return next_change;
}

bool stock_changed(const StockWait& wait,
                   const CompiledBrain& brain,
                   std::size_t leaf,
                   const PointsOfInterest& points_of_interest,
                   Tick now) {
    const std::span<const Clause> clauses = brain.clauses_of(leaf);
    return std::any_of(clauses.begin(), clauses.end(), [&](const Clause& clause) {
        if (clause.on_stock == 0 || clause.stock_number >= StockWait::kMostClauses ||
            (wait.clauses >> clause.stock_number & 1U) == 0) {
            return false;
        }
        const bool held = (wait.held >> clause.stock_number & 1U) != 0;
        return stock_holds(brain.on_stock(clause), brain, points_of_interest, now) != held;
    });
}

Tick able_from(const Agent& agent, const CompiledBrain& brain, const Trade& trade, Tick now) {
    Tick from = now + 1;
    for (const TradeItem& item : trade.items) {
        const BrainVariable& of = brain.variables[item.variable];
        const auto then = [&](Tick at) {
            return variable_at(agent, brain, item.variable, at) + item.amount;
        };
        const bool lacks = then(now) < of.low;
        if (!lacks && !(then(now) > of.high)) {
            continue;
        }
        const float way = (lacks ? of.low : of.high) - then(now);
        const float per_tick = rate_of(agent, brain, item.variable);
        if (per_tick == 0.0F || lacks != (per_tick > 0.0F)) {
            return kNever;
        }
        from = std::max(from, first_at(now, way / per_tick, [&](Tick at) {
                            return lacks ? then(at) >= of.low : then(at) <= of.high;
                        }));
    }
    return from;
}

}  // namespace zoned::ai
