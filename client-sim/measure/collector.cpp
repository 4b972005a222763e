#include "client-sim/measure/collector.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::measure {

namespace {

constexpr double kPeriodS = 0.1;
constexpr double kClockPeriodS = 1.0;
/// An event is closed when no client has received it for this long.
constexpr double kEventOpenS = 4.0;
/// At the end of the run events are closed sooner, but not events that may still be in flight.
constexpr double kLastEventOpenS = 1.0;
/// Bandwidth is measured from this long after a bot joined: the first view is not the steady one.
constexpr double kWarmUpS = 2.0;
/// After this time no client can display a change of direction any more.
constexpr double kCourseOpenS = 1.0;
/// A client that receives nothing for this long at the end is cut off.
constexpr double kSilentS = 2.0;

/// Bit of the rights in Welcome.
constexpr std::uint32_t kRightAudit = 2;

bool online(const bot::Bot& bot) {
    return bot.client().state() == link::SessionState::kOnline;
}

/// Tells worlds apart. Those of a cluster may have the same description.
const std::string& world_of(const bot::Bot& bot) {
    return bot.client().world_name();
}

}  // namespace

Collector::Collector(std::size_t bots, int header_bytes, double spread_s)
    : header_bytes_(header_bytes) {
    per_bot_.reserve(bots);
    for (std::size_t i = 0; i < bots; ++i) {
        per_bot_.push_back({audit::Auditor(i, spread_s), {}, {}, false, false});
    }
}

void Collector::on_joined(bot::Bot& bot, const wire::JoinedMessage&) {
    PerBot& mine = per_bot_[bot.settings().index];
    mine.joined = true;
    mine.auditor.restart();
}

void Collector::on_set_back(bot::Bot& bot) {
    per_bot_[bot.settings().index].auditor.restart();
}

void Collector::on_event(bot::Bot& bot, const wire::EventMessage& event) {
    if (event.history) {
        return;  // others received it long ago: nothing to compare
    }
    const double now = bot.now_s();
    auto [at, fresh] = event_spreads_.try_emplace({world_of(bot), event.event_id});
    EventSpread& heard = at->second;
    if (fresh) {
        heard.first_s = now;
        heard.tick = event.tick;
        heard.world = event.topic == "world";
    }
    heard.last_s = now;
    ++heard.bots;
}

void Collector::on_audit(bot::Bot& bot, const wire::AuditRecordMessage& record) {
    PerBot& mine = per_bot_[bot.settings().index];
    if (!ended_) {
        mine.corrections.decide(
            record.tick, record.avatar_discontinuity_tick, correction_m_, jump_m_);
    }
    if (!ended_ || record.frozen) {
        mine.auditor.add(record);
    }
}

void Collector::on_changed_course(bot::Bot& bot, Tick tick) {
    if (!bot.avatar()) {
        return;
    }
    CourseChange& course = courses_[{world_of(bot), bot.avatar().value}];
    unseen_ += course.open ? 1 : 0;
    course = {tick,
              bot.now_s(),
              bot.client().clock().server_time(bot.now_s()),
              bot.settings().index,
              true};
}

void Collector::on_shown(bot::Bot& bot, EntityId entity, Tick publication_tick, Tick from_tick) {
    const auto found = courses_.find({world_of(bot), entity.value});
    if (found == courses_.end() || !found->second.open || publication_tick < found->second.tick) {
        return;
    }
    found->second.open = false;
    const double elapsed = bot.now_s() - found->second.decided_s;
    if (elapsed > kCourseOpenS) {
        // A change this late is another one: the avatar walked into a wall, or no client was near.
        ++unseen_;
        return;
    }
    // It comes on the screen with the next tick that is displayed.
    const double shown_server_s = static_cast<double>(from_tick) * bot.view()->world().tick_s;
    const double wait = shown_server_s - bot.client().clock().server_time(bot.now_s());
    display_ms_.add(1e3 * (elapsed + std::max(0.0, wait)));
    const CourseChange& course = found->second;
    latency_.add(
        course.decider, course.tick, course.decided_server_s, bot, publication_tick, from_tick);
}

void Collector::on_correction(bot::Bot& bot, Tick tick, double distance_m) {
    if (!ended_) {
        per_bot_[bot.settings().index].corrections.add(tick, distance_m);
    }
}

void Collector::advance(const Bots& bots, double now_s) {
    if (now_s < next_s_) {
        return;
    }
    next_s_ = now_s + kPeriodS;
    for (const auto& bot : bots) {
        per_bot_[bot->settings().index].auditor.settle(bot->player(), bot->audited(), tally_);
    }
    close_events(bots, now_s, kEventOpenS);
    latency_.settle(bots);
    if (now_s >= next_clock_s_ && !ended_) {
        next_clock_s_ = now_s + kClockPeriodS;
        sample_clocks(bots, now_s);
        take_baselines(bots, now_s);
    }
}

void Collector::close_events(const Bots& bots, double now_s, double open_s) {
    for (auto it = event_spreads_.begin(); it != event_spreads_.end();) {
        const EventSpread& heard = it->second;
        if (now_s - heard.last_s < open_s) {
            ++it;
            continue;
        }
        if (heard.bots > 1) {
            spread_ms_.add(1e3 * (heard.last_s - heard.first_s));
        }
        if (heard.world) {
            // Every client that had joined well before must have received it.
            std::uint64_t audience = 0;
            for (const auto& bot : bots) {
                const bool there = bot->joined() && bot->view() != nullptr && online(*bot) &&
                                   world_of(*bot) == it->first.first &&
                                   static_cast<double>(heard.tick - bot->joined_tick()) *
                                           bot->view()->world().tick_s >
                                       1.0;
                audience += there ? 1 : 0;
            }
            unheard_ += audience > heard.bots ? audience - heard.bots : 0;
        }
        it = event_spreads_.erase(it);
    }
}

void Collector::sample_clocks(const Bots& bots, double) {
    // All bots live on one clock, and those of a world talk to one server: their offsets ought to
    // be equal. The one with the shortest round trip knows best.
    struct BestClock {
        double rtt_s = std::numeric_limits<double>::infinity();
        double offset_s = 0.0;
    };

    std::map<std::string, BestClock> best;
    for (const auto& bot : bots) {
        const clock::ClockSync& clock = bot->client().clock();
        if (online(*bot) && bot->settled_tick() >= 0 &&
            clock.min_rtt_s() < best[world_of(*bot)].rtt_s) {
            best[world_of(*bot)] = {clock.min_rtt_s(), clock.offset_s()};
        }
    }
    for (const auto& bot : bots) {
        const clock::ClockSync& clock = bot->client().clock();
        if (!online(*bot) || bot->settled_tick() < 0) {
            continue;
        }
        rtt_ms_.add(1e3 * clock.rtt_s());
        lead_ticks_.add(bot->lead_ticks());
        view_delay_ticks_.add(static_cast<double>(bot->view()->delay()));
        const BestClock& of_world = best[world_of(*bot)];
        clock_error_ms_.add(1e3 * std::abs(clock.offset_s() - of_world.offset_s));
        clock_bound_ms_ =
            std::max(clock_bound_ms_, 1e3 * (clock.error_bound_s() + 0.5 * of_world.rtt_s));
    }
}

void Collector::take_baselines(const Bots& bots, double now_s) {
    for (const auto& bot : bots) {
        Baseline& b = per_bot_[bot->settings().index].baseline;
        if (b.taken || !bot->joined() || bot->view() == nullptr ||
            now_s - bot->joined_s() < kWarmUpS) {
            continue;
        }
        const link::DatagramStats& d = bot->client().datagrams();
        const link::SessionStats& s = bot->client().stats();
        b = {true,
             false,
             now_s,
             d.in,
             d.bytes_in,
             d.out,
             d.bytes_out,
             s.frame_bytes_in,
             s.audit_bytes_in,
             bot->view()->stats().shown};
    }
}

void Collector::end_run(const Bots& bots, double now_s) {
    ended_ = true;
    for (PerBot& mine : per_bot_) {
        mine.corrections.finish(correction_m_);
    }
    close_events(bots, now_s, kLastEventOpenS);
    for (const auto& bot : bots) {
        PerBot& mine = per_bot_[bot->settings().index];
        if (online(*bot) && mine.joined && now_s - bot->client().last_packet_s() > kSilentS) {
            mine.silent = true;
        }
        const Baseline& b = mine.baseline;
        const double seconds = now_s - b.at_s;
        if (!b.taken || seconds < 1.0 || bot->view() == nullptr) {
            continue;
        }
        const link::DatagramStats& d = bot->client().datagrams();
        const link::SessionStats& s = bot->client().stats();
        const auto rate = [&](std::uint64_t bytes, std::uint64_t packets) {
            return (static_cast<double>(bytes) +
                    static_cast<double>(packets) * static_cast<double>(header_bytes_)) /
                   seconds;
        };
        down_.add(rate(d.bytes_in - b.bytes_in, d.in - b.in));
        up_.add(rate(d.bytes_out - b.bytes_out, d.out - b.out));
        const std::uint64_t audits = s.audit_bytes_in - b.audit_bytes_in;
        stream_.add(rate(s.frame_bytes_in - b.frame_bytes_in - audits, 0));
        audit_bytes_.add(rate(audits, 0));
        const std::uint64_t shown = bot->view()->stats().shown;
        updates_ += shown > b.shown ? static_cast<double>(shown - b.shown) : 0.0;
        update_seconds_ += seconds;
    }
}

Collector::ConvergedBots Collector::convergence(const Bots& bots) const {
    ConvergedBots result;
    for (const auto& bot : bots) {
        const PerBot& mine = per_bot_[bot->settings().index];
        if (!mine.joined || !online(*bot) || (bot->client().rights() & kRightAudit) == 0) {
            continue;
        }
        ++result.online;
        result.seen += mine.auditor.frozen().seen ? 1 : 0;
        result.converged += mine.auditor.frozen().converged ? 1 : 0;
    }
    return result;
}

void Collector::forget_frozen() {
    for (PerBot& mine : per_bot_) {
        mine.auditor.forget_frozen();
    }
}

void Collector::count_bot(const bot::Bot& bot, RunReport& r) const {
    const PerBot& mine = per_bot_[bot.settings().index];
    const link::Client& client = bot.client();
    r.bots_joined += mine.joined ? 1 : 0;
    const bool travels = client.on_its_way();
    r.bots_lost += mine.joined && !online(bot) && !travels ? 1 : 0;
    r.travels += client.stats().travels;
    r.travels_prepared += client.stats().travels_prepared;
    r.redirects += client.stats().redirects;
    for (const double gap_s : client.stats().travel_gaps_s) {
        r.travel_gap_ms.add(1e3 * gap_s);
    }
    if (!client.trouble().empty() && !travels && (!mine.joined || !online(bot))) {
        ++r.troubles[client.trouble()];
    } else if (bot.bad_worlds() > 0) {
        ++r.troubles["the server's world description makes no sense"];
    }
    r.SessionFaults::add(bot.player());
    r.events_sent += client.events().numbered();
    r.events_delivered += client.events().delivered();
    r.decisions_diverged += bot.ledger().diverged();
    r.commands_sent += client.stats().commands_sent;
    r.commands_resent += client.stats().commands_resent;
    r.streams_lost += client.stats().streams_lost;
    r.resumed += client.stats().resumed;
    r.recovered += client.stats().recovered;
    r.input_ticks += bot.inputs().ticks;
    r.input_ticks_missing += bot.inputs().missing;
    r.tunnelled_bots += client.stats().tunnelled ? 1 : 0;
    r.packets_received += bot.arrivals().received();
    r.packets_lost += bot.arrivals().missing();
    r.replayed += client.datagrams().replayed;
    r.unauthenticated += client.datagrams().unauthenticated;
    r.clock_set_backs += bot.set_backs();
    r.silent_bots += mine.silent ? 1 : 0;
    if (bot.view() != nullptr) {
        const view::ViewStats& v = bot.view()->stats();
        r.traffic.add(bot.view()->traffic());
        if (r.traffic_types.empty()) {
            for (const auto& type : bot.view()->world().types) {
                r.traffic_types.push_back(type.name);
            }
        }
        r.view_resets += v.resets;
        r.unknown_keyframes += v.unknown_keyframes;
        r.environment_updates += v.environment_updates;
        r.environment_corrected += v.environment_corrected;
        r.bursts += v.bursts;
        r.bursts_malformed += v.bursts_malformed;
        r.bursts_refused += v.bursts_refused;
        r.zone_changes += v.zone_changes;
        r.input_missing += v.input_missing;
        r.publications_absolute += v.absolutes;
        for (std::size_t i = 0; i < v.by_order.size(); ++i) {
            r.publications_by_order[i] += v.by_order[i];
        }
    }
    const audit::FrozenState& frozen = mine.auditor.frozen();
    if (online(bot) && mine.joined && (client.rights() & kRightAudit) != 0) {
        ++r.auditing_bots;
        r.frozen_bots += frozen.seen ? 1 : 0;
        r.converged_bots += frozen.converged ? 1 : 0;
        if (frozen.seen && !frozen.converged && r.frozen_difference.empty()) {
            r.frozen_difference =
                "bot " + std::to_string(bot.settings().index) + ": " + frozen.difference;
        }
    }
}

RunReport Collector::report(const Bots& bots, std::size_t asked) const {
    RunReport r;
    r.bots_asked = asked;
    r.audit = tally_;
    r.event_spread_ms = spread_ms_;
    r.events_unheard = unheard_;
    r.input_to_remote_display_ms = display_ms_;
    r.latency_stages_ms = latency_.stages();
    r.latency_unknown = latency_.unknown();
    r.input_changes_unseen = unseen_;
    r.rtt_ms = rtt_ms_;
    r.clock_error_ms = clock_error_ms_;
    r.clock_bound_ms = clock_bound_ms_;
    r.own_correction_m = correction_m_;
    r.own_jump_m = jump_m_;
    r.lead_ticks = lead_ticks_;
    r.view_delay_ticks = view_delay_ticks_;
    r.down_bytes_per_s = down_;
    r.up_bytes_per_s = up_;
    r.down_stream_bytes_per_s = stream_;
    r.audit_bytes_per_s = audit_bytes_;
    r.updates_per_s = update_seconds_ > 0.0 ? updates_ / update_seconds_ : 0.0;
    for (const auto& bot : bots) {
        count_bot(*bot, r);
    }
    return r;
}

}  // namespace zoned::measure
