#include "client-sim/app/swarm.h"

#include <algorithm>
#include <set>
#include <utility>

namespace zoned::app {

namespace {

/// The run begins without the bots that have not joined by then.
constexpr double kSettleS = 10.0;
/// Time for the last frames to leave.
constexpr double kGoodbyeS = 0.5;
/// Bits of the rights in Welcome.
constexpr std::uint32_t kRightAudit = 2;
constexpr std::uint32_t kRightFreeze = 4;

std::string describe(const std::vector<bot::Share>& mix) {
    std::string text;
    for (const bot::Share& share : mix) {
        char number[32];
        std::snprintf(number, sizeof(number), "%g", share.share);
        text += (text.empty() ? "" : ",") + std::string(bot::name_of(share.script)) + ":" + number;
    }
    return text;
}

const char* name_of(motion::ConvergenceMethod method) {
    switch (method) {
        case motion::ConvergenceMethod::kSnap:
            return "snap";
        case motion::ConvergenceMethod::kLinear:
            return "linear";
        case motion::ConvergenceMethod::kProjectiveVelocity:
            return "projective";
        case motion::ConvergenceMethod::kHermite:
            return "hermite";
    }
    return "?";
}

}  // namespace

Swarm::Swarm(SwarmSettings settings, const MakeTransport& make_transport)
    : settings_(std::move(settings)),
      collector_(settings_.bots, settings_.header_bytes, settings_.path_spread_s) {
    const std::vector<bot::Script> dealt = bot::deal(settings_.mix, settings_.bots);
    for (std::size_t i = 0; i < settings_.bots; ++i) {
        transports_.push_back(make_transport(i));
        bot::BotSettings one;
        one.login.name = "bot-" + std::to_string(i);
        if (!settings_.teams.empty()) {
            one.login.team = settings_.teams[i % settings_.teams.size()];
        }
        if (i < settings_.tickets.size()) {
            one.login.ticket = settings_.tickets[i];
        }
        one.login.config_digest = settings_.config_digest;
        one.login.world = settings_.world;
        one.script = dealt[i];
        one.make_own_script = settings_.make_own_script;
        one.seed = settings_.seed;
        one.index = i;
        one.convergence = settings_.convergence;
        one.view = settings_.view;
        one.displayed_state = settings_.displayed_state;
        one.meter = settings_.meter;
        one.audit_every_s = settings_.audit ? settings_.audit_every_s : 0.0;
        bots_.push_back(
            std::make_unique<bot::Bot>(*transports_.back(), worlds_, collector_, std::move(one)));
    }
}

Swarm::~Swarm() = default;

void Swarm::advance(double now_s) {
    if (begun_s_ < 0.0) {
        begun_s_ = now_s;
        phase_s_ = now_s;
    }
    if (phase_ == RunPhase::kDone) {
        return;
    }
    for (std::size_t i = 0; i < started_; ++i) {
        bots_[i]->advance(now_s);
    }
    collector_.advance(bots_, now_s);
    switch (phase_) {
        case RunPhase::kRamp:
            ramp(now_s);
            break;
        case RunPhase::kSettle: {
            const bool all = std::all_of(bots_.begin(), bots_.end(), [](const auto& bot) {
                return bot->joined() || bot->client().state() == link::SessionState::kClosed;
            });
            if (all || now_s - phase_s_ > kSettleS) {
                enter_run(now_s);
            }
            break;
        }
        case RunPhase::kRun:
            if (now_s - phase_s_ >= settings_.seconds || all_closed()) {
                end_run(now_s);
            }
            break;
        case RunPhase::kFreeze:
            freeze(now_s);
            break;
        case RunPhase::kGoodbye:
            if (now_s - phase_s_ >= kGoodbyeS || all_closed()) {
                phase_ = RunPhase::kDone;
            }
            break;
        case RunPhase::kDone:
            break;
    }
}

void Swarm::ramp(double now_s) {
    const auto due = static_cast<std::size_t>((now_s - begun_s_) * settings_.ramp_per_s) + 1;
    while (started_ < std::min(due, bots_.size())) {
        bots_[started_++]->start(now_s);
    }
    if (started_ == bots_.size()) {
        phase_ = RunPhase::kSettle;
        phase_s_ = now_s;
    }
}

void Swarm::enter_run(double now_s) {
    phase_ = RunPhase::kRun;
    phase_s_ = now_s;
}

void Swarm::end_run(double now_s) {
    if (phase_ == RunPhase::kRun) {
        run_seconds_ = now_s - phase_s_;
        collector_.end_run(bots_, now_s);
        enter_freeze(now_s);
    }
}

bool Swarm::all_closed() const {
    return std::all_of(bots_.begin(), bots_.end(), [](const auto& bot) {
        return bot->client().state() == link::SessionState::kClosed;
    });
}

bool Swarm::ask_to_freeze(bool on) const {
    std::set<std::string> worlds;
    for (const auto& bot : bots_) {
        if (bot->client().state() == link::SessionState::kOnline && bot->view() != nullptr &&
            (bot->client().rights() & kRightFreeze) != 0 &&
            worlds.insert(bot->client().world_name()).second) {
            bot->client().request_freeze(on);
        }
    }
    return !worlds.empty();
}

void Swarm::enter_freeze(double now_s) {
    if (!settings_.freeze || !settings_.audit || !ask_to_freeze(true)) {
        enter_goodbye(now_s);
        return;
    }
    phase_ = RunPhase::kFreeze;
    phase_s_ = now_s;
    freeze_asked_ = true;
    collector_.forget_frozen();
    for (const auto& bot : bots_) {
        bot->set_quiet(true);
    }
    next_audit_s_ = now_s + settings_.frozen_audit_s;
}

void Swarm::freeze(double now_s) {
    if (now_s >= next_audit_s_) {
        next_audit_s_ = now_s + settings_.frozen_audit_s;
        for (const auto& bot : bots_) {
            if ((bot->client().rights() & kRightAudit) != 0) {
                bot->client().request_audit();
            }
        }
    }
    const measure::Collector::ConvergedBots state = collector_.convergence(bots_);
    const bool converged = state.online > 0 && state.converged == state.online;
    if (converged || now_s - phase_s_ >= settings_.freeze_wait_s) {
        static_cast<void>(ask_to_freeze(false));
        enter_goodbye(now_s);
    }
}

void Swarm::enter_goodbye(double now_s) {
    final_ = collector_.report(bots_, settings_.bots);
    final_.seconds = run_seconds_;
    final_.script = settings_.make_own_script ? "own" : describe(settings_.mix);
    final_.convergence = name_of(settings_.convergence);
    final_.view = settings_.view == view::ViewKind::kInterpolate ? "interpolate" : "extrapolate";
    final_.predictor =
        settings_.displayed_state == view::DisplayedState::kPublished ? "none" : "published";
    final_.seed = settings_.seed;
    final_.audits_expected = settings_.audit;
    final_.freeze_asked = freeze_asked_;
    measure::judge(final_);
    phase_ = RunPhase::kGoodbye;
    phase_s_ = now_s;
    for (std::size_t i = 0; i < started_; ++i) {
        bots_[i]->quit(now_s);
    }
}

void Swarm::stop(double now_s) {
    if (phase_ == RunPhase::kGoodbye || phase_ == RunPhase::kDone) {
        return;
    }
    if (phase_ != RunPhase::kFreeze) {
        run_seconds_ = phase_ == RunPhase::kRun ? now_s - phase_s_ : 0.0;
        collector_.end_run(bots_, now_s);
    } else if (ask_to_freeze(false)) {
        // A world left frozen would be a bad farewell.
        freeze_asked_ = false;
    }
    enter_goodbye(now_s);
}

measure::RunReport Swarm::report() const {
    return final_;
}

Swarm::Progress Swarm::progress(double now_s) const {
    static constexpr const char* kNames[] = {
        "joining", "settling", "running", "frozen", "leaving", "done"};
    Progress p;
    p.phase = kNames[static_cast<std::size_t>(phase_)];
    p.started = started_;
    for (const auto& bot : bots_) {
        p.online += bot->client().state() == link::SessionState::kOnline ? 1 : 0;
        p.joined += bot->joined() ? 1 : 0;
    }
    const audit::Tally& t = collector_.tally();
    p.samples = t.samples;
    p.findings =
        t.position_violations + t.orientation_violations + t.missing + t.extra + t.field_violations;
    if (phase_ == RunPhase::kRun) {
        p.seconds_left = std::max(0.0, settings_.seconds - (now_s - phase_s_));
    }
    return p;
}

std::string Swarm::unreachable() const {
    std::string why;
    for (const auto& bot : bots_) {
        if (bot->client().ever_online()) {
            return {};
        }
        if (why.empty()) {
            why = bot->client().trouble();
        }
    }
    return why.rfind("refused", 0) == 0 ? std::string() : why;
}

}  // namespace zoned::app
