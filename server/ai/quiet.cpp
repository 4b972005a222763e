#include "server/ai/quiet.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// Decisions whose random numbers are looked at in advance.
constexpr int kLookAhead = 64;

/// The state of one mind, asked about one condition after the other.
class Forecast {
  public:
    Forecast(const Mind& mind,
             const CompiledMachine& machine,
             const Senses& senses,
             const Outlook& outlook,
             Tick now)
        : mind_(mind),
          machine_(machine),
          senses_(senses),
          step_m_(outlook.speed * outlook.dt),
          day_s_(outlook.day_s),
          now_(now),
          dt_(outlook.dt) {}

    /// A tick before which the condition stays as it is.
    [[nodiscard]] Tick change_of(const Watch& watch) const {
        if (watch.sense >= machine_.senses) {
            return elapsed(watch);
        }
        const float value = senses_[watch.sense];
        switch (watch.sense) {
            case kSensePlayerDistance:
            case kSenseConfidence:
            case kSenseAllies:
            case kSenseFoes:
                return kNever;
            case kSenseHomeDistance:
                return after(std::abs(value - watch.threshold), step_m_);
            case kSenseRandom:
                return drawn(watch);
            case kSenseTimeOfDay:
                return after((value <= watch.threshold ? watch.threshold : day_s_) - value, dt_);
            default:
                break;
        }
        const std::size_t own = watch.sense - kOwnSenses;
        if (own < machine_.variables.size()) {
            return grown(own, watch.threshold);
        }
        if (watch.sense >= machine_.first_place_sense) {
            // Others trade as well: stock may change at any time.
            const bool distance =
                machine_.places[watch.sense - machine_.first_place_sense].stock < 0;
            return distance ? after(std::abs(value - watch.threshold), step_m_) : now_ + 1;
        }
        return fuzzy_changes(watch.sense) ? now_ + 1 : kNever;
    }

  private:
    /// Ticks until something that changes by at most `per_tick` has changed by `amount`, less one
    /// for rounding.
    [[nodiscard]] Tick after(float amount, float per_tick) const {
        if (!(per_tick > 0.0F)) {
            return kNever;
        }
        const float ticks = std::floor(amount / per_tick) - 1.0F;
        return ticks < 1e9F ? now_ + std::max<Tick>(1, static_cast<Tick>(ticks)) : kNever;
    }

    /// Time in a state, which begins at the tick in which the state was entered.
    [[nodiscard]] Tick elapsed(const Watch& watch) const {
        const Tick since = mind_.fsm.since[watch.sense - machine_.senses][0];
        const float in_state = static_cast<float>(now_ - since) * dt_;
        return in_state > watch.threshold ? kNever : after(watch.threshold - in_state, dt_);
    }

    [[nodiscard]] float rate(std::size_t variable) const {
        return machine_.rates[mind_.doing * machine_.variables.size() + variable];
    }

    /// Whether a variable is where its growth ends.
    [[nodiscard]] bool settled(std::size_t variable) const {
        const float per_tick = rate(variable);
        const float value = senses_[kOwnSenses + variable];
        const Variable& of = machine_.variables[variable];
        return per_tick == 0.0F || (per_tick > 0.0F ? value >= of.high : value <= of.low);
    }

    [[nodiscard]] Tick grown(std::size_t variable, float threshold) const {
        const float per_tick = rate(variable);
        const float way = threshold - senses_[kOwnSenses + variable];
        if (settled(variable) || (way != 0.0F && (way > 0.0F) != (per_tick > 0.0F))) {
            return kNever;
        }
        return after(std::abs(way), std::abs(per_tick));
    }

    /// The next decision at which the number drawn says otherwise.
    [[nodiscard]] Tick drawn(const Watch& watch) const {
        const Tick period = decision_period(machine_, dt_);
        Tick at = now_;
        for (int k = 0; k < kLookAhead; ++k) {
            at = next_decision(mind_.entity, period, at);
            if (holds({watch.sense, watch.compare, watch.threshold}, drawn_at(mind_, at)) !=
                holds({watch.sense, watch.compare, watch.threshold}, senses_[watch.sense])) {
                return at;
            }
        }
        return at + 1;
    }

    [[nodiscard]] bool fuzzy_changes(SenseIndex sense) const {
        for (const CompiledMachine::Fuzzy& fuzzy : machine_.fuzzy) {
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

    const Mind& mind_;
    const CompiledMachine& machine_;
    const Senses& senses_;
    float step_m_;
    float day_s_;
    Tick now_;
    float dt_;
};

}  // namespace

Tick quiet_until(const Mind& mind,
                 const CompiledMachine& machine,
                 const Senses& senses,
                 const Outlook& outlook,
                 Tick now) {
    const Forecast forecast(mind, machine, senses, outlook, now);
    Tick until = kNever;
    for (const Watch& watch : machine.watched(mind.fsm.state())) {
        until = std::min(until, forecast.change_of(watch));
    }
    if (mind.fsm.pending[0] != fsm::kNone) {
        const Tick hold = machine.table.transitions[mind.fsm.pending[0]].hold;
        until = std::min(until, mind.fsm.pending_since[0] + hold);
    }
    return std::max(until, now + 1);
}

}  // namespace zoned::ai
