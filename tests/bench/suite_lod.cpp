// Suite `lod`: a day of a town, without walls and with them, fully simulated and with off-screen
// agents skipped. The outcome has to be the same.
#include "server/ai/agent/decision.h"
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "tests/bench/comparison.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/statistics.h"
#include "tests/bench/suite.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

namespace zoned::bench {

namespace {

/// In the open people walk straight; with walls they follow planned paths.
const std::string kTownScene = "town_day";
const std::string kWalledScene = "walled_town_day";
/// Walls with openings between the places where people go.
const std::string kWalls =
    "statics {\n"
    "  wall { point { x_m: -200 z_m: 20 } point { x_m: 200 z_m: 24 } height_m: 3 segment_m: 18 "
    "gap_m: 6 }\n"
    "  wall { point { x_m: 30 z_m: -150 } point { x_m: 34 z_m: 150 } height_m: 3 segment_m: 18 "
    "gap_m: 6 }\n"
    "  wall { point { x_m: -260 z_m: 95 } point { x_m: -60 z_m: 95 } height_m: 3 segment_m: 30 "
    "gap_m: 8 }\n"
    "  wall { point { x_m: -130 z_m: -120 } point { x_m: -20 z_m: -130 } height_m: 3 segment_m: 18 "
    "gap_m: 6 }\n"
    "}\n";
constexpr double kDay_s = 600.0;

/// The bound of the config's farthest level of detail, m, which is promised to an arriving viewer.
constexpr double kFarBound_m = 0.5;

/// Types whose days depend on no other agent, and types that compete for scarce goods or follow
/// chance.
constexpr std::array kScheduled = {"fisher", "farmer", "guard", "mayfly"};
constexpr std::array kContested = {"porter", "pilgrim"};
/// Variables that only trades and meals change: whole numbers.
constexpr std::array kGoods = {"fish", "coins", "bread", "parcel", "days"};

/// The action that an agent turned to, and the goods it had then.
struct Turn {
    Tick tick = 0;
    std::uint16_t current_action = 0;
    std::int64_t goods = 0;
};

struct Person {
    std::string type;
    std::vector<Turn> turns;
    Vec2 at = Vec2::Zero();  ///< in the end
};

/// The outcome of a day.
struct Day {
    std::map<std::uint32_t, Person> people;  ///< by entity
    std::map<std::string, double> totals;    ///< of goods, by type that is contested
    std::uint32_t dead = 0;
    std::vector<double> tick_us;
    std::uint64_t active = 0;
    std::uint64_t events = 0;
};

/// `count` people in one zone. Returns the mistakes.
std::string read_town(const std::string& scene,
                      int count,
                      std::uint64_t seed,
                      bool suspend_offscreen,
                      config::Settings& settings) {
    // In the order of the config's scatters: fishers, farmers, porters, pilgrims, guards, mayflies;
    // one each of hounds, children and deer.
    const std::array shares = {0.3, 0.3, 0.06, 0.2, 0.06, 0.077, 0.0, 0.0, 0.0};
    std::vector<std::string> sets = {
        "zones.zone_grid.columns=1",
        "zones.zone_grid.rows=1",
        "world.seed=" + std::to_string(seed),
        std::string("ai.suspend_offscreen=") + (suspend_offscreen ? "true" : "false")};
    for (std::size_t k = 0; k < shares.size(); ++k) {
        sets.push_back("scatter[" + std::to_string(k) + "].count=" +
                       std::to_string(std::max(1, static_cast<int>(shares[k] * count))));
    }
    // The files that a text names are looked for in the current folder.
    const std::string folder = ZONED_SOURCE_DIR "/config/";
    sets.push_back("policy[0].file=" + folder + "training/arena.policy");
    std::ifstream file(folder + "town.txtpb");
    std::stringstream text;
    text << file.rdbuf() << (scene == kWalledScene ? kWalls : "");
    std::vector<config::ConfigError> errors;
    if (!config::parse_settings(text.str(), sets, settings, errors)) {
        return config::format_errors("config/town.txtpb", errors);
    }
    const bool has_paths = settings.ai.pathfinding.cell_m > 0.0F;
    return has_paths == (scene == kWalledScene) ? "" : "paths are planned in the wrong scene";
}

std::int64_t goods_of(const ai::Agent& agent, const ai::CompiledBrain& brain, Tick now) {
    std::int64_t goods = 0;
    for (std::size_t v = 0; v < brain.variables.size(); ++v) {
        if (std::find(kGoods.begin(), kGoods.end(), brain.variables[v].name) != kGoods.end()) {
            goods = goods * 1009 + std::llround(ai::variable_at(agent, brain, v, now));
        }
    }
    return goods;
}

/// A day from dawn to dawn, with the turns of all agents recorded.
class DayTrial {
  public:
    DayTrial(const config::Settings& settings) : settings_(settings), world_(settings, 1) {}

    Day run(double seconds) {
        const auto ticks = static_cast<Tick>(seconds * settings_.tick_rate_hz);
        for (Tick t = 0; t < ticks; ++t) {
            const std::int64_t before = thread_cpu_ns();
            world_.tick({}, out_);
            day_.tick_us.push_back(static_cast<double>(thread_cpu_ns() - before) * 1e-3);
            out_.clear();
            const ai::AiReport& report = zone().report().ai;
            day_.active += report.active;
            day_.events += report.events;
            write_down();
        }
        end();
        return std::move(day_);
    }

  private:
    [[nodiscard]] const zone::Zone& zone() const { return *world_.zones().front(); }

    void write_down() {
        const zone::ZoneState& state = zone().state();
        for (std::size_t n = 0; n < state.agents.size(); ++n) {
            const ai::Agent& agent = state.agents.at(state.agents.nth(n));
            Person& person = day_.people[agent.entity.value];
            if (person.turns.empty() ||
                person.turns.back().current_action != agent.current_action) {
                person.turns.push_back(
                    {world_.now(),
                     agent.current_action,
                     goods_of(agent, settings_.ai.compiled[agent.brain], world_.now())});
            }
        }
    }

    void end() {
        const zone::ZoneState& state = zone().state();
        for (std::size_t n = 0; n < state.agents.size(); ++n) {
            const ai::Agent& agent = state.agents.at(state.agents.nth(n));
            const world::Row row = state.entities.find(agent.entity);
            const ai::CompiledBrain& brain = settings_.ai.compiled[agent.brain];
            Person& person = day_.people[agent.entity.value];
            person.type = settings_.types[state.entities.type[row]].name;
            const Vec3& at = state.entities.position[row];
            person.at = agent.tier == ai::Tier::kSuspended
                            ? ai::position_at(agent.segment, world_.now(), state.settings.dt)
                            : Vec2(at.x(), at.z());
            day_.dead += brain.states[agent.current_action].name == "dead" ? 1U : 0U;
            for (std::size_t v = 0; v < brain.variables.size(); ++v) {
                if (brain.variables[v].name == "coins") {
                    day_.totals[person.type] += std::round(
                        static_cast<double>(ai::variable_at(agent, brain, v, world_.now())));
                }
            }
        }
    }

    const config::Settings& settings_;
    app::World world_;
    std::vector<mailbox::OutboxItem> out_;
    Day day_;
};

/// The differences between a skipped day and the same day simulated.
struct Differences {
    std::uint32_t people = 0;     ///< that keep a schedule
    std::uint32_t turns = 0;      ///< that were compared
    std::uint32_t scheduled = 0;  ///< people whose action or goods differ
    double arrival_s = 0.0;       ///< the largest
    std::vector<double> places_m;

    void compare(const Day& full, const Day& skipped, double tick_s) {
        for (const auto& [id, person] : full.people) {
            if (std::find(kScheduled.begin(), kScheduled.end(), person.type) != kScheduled.end()) {
                ++people;
                compare(person, skipped.people.at(id), tick_s);
            }
        }
        scheduled += full.dead != skipped.dead ? 1U : 0U;
    }

    void compare(const Person& a, const Person& b, double tick_s) {
        bool same = a.turns.size() == b.turns.size();
        for (std::size_t k = 0; same && k < a.turns.size(); ++k) {
            const Turn& x = a.turns[k];
            const Turn& y = b.turns[k];
            same = x.current_action == y.current_action && x.goods == y.goods;
            arrival_s =
                std::max(arrival_s, std::abs(static_cast<double>(x.tick - y.tick)) * tick_s);
            ++turns;
        }
        scheduled += same ? 0U : 1U;
        places_m.push_back(static_cast<double>((a.at - b.at).norm()));
    }
};

/// The totals of skipped days that lie outside the prediction interval of the simulated days. One
/// more simulated day would lie within it with a probability of 99 %. The interval is that of
/// normal samples, mean +- t s sqrt(1 + 1/n) (Hahn and Meeker, "Statistical Intervals", 1991,
/// section 4.8).
std::uint32_t outside_band(const std::vector<Day>& full, const std::vector<Day>& skipped) {
    // Quantiles 0.995 of Student's t with n - 1 degrees of freedom, n from 2 to 20; beyond, that of
    // 20.
    constexpr std::array kT = {63.66,
                               9.925,
                               5.841,
                               4.604,
                               4.032,
                               3.707,
                               3.499,
                               3.355,
                               3.250,
                               3.169,
                               3.106,
                               3.055,
                               3.012,
                               2.977,
                               2.947,
                               2.921,
                               2.898,
                               2.878,
                               2.861};
    std::uint32_t outside = 0;
    for (const char* type : kContested) {
        std::vector<double> totals;
        for (const Day& day : full) {
            totals.push_back(day.totals.at(type));
        }
        const auto n = static_cast<double>(totals.size());
        const double centre = mean(totals);
        double sum = 0.0;
        for (const double total : totals) {
            sum += (total - centre) * (total - centre);
        }
        const double s = std::sqrt(sum / std::max(1.0, n - 1.0));
        const double half =
            kT[std::min(kT.size(), totals.size() - 1) - 1] * s * std::sqrt(1.0 + 1.0 / n);
        for (const Day& day : skipped) {
            outside += std::abs(day.totals.at(type) - centre) > half ? 1U : 0U;
        }
    }
    return outside;
}

std::vector<double> all_ticks(const std::vector<Day>& days) {
    std::vector<double> all;
    for (const Day& day : days) {
        all.insert(all.end(), day.tick_us.begin(), day.tick_us.end());
    }
    return all;
}

Row row_of(const std::string& scene,
           const std::string& method,
           const std::vector<Day>& days,
           int count) {
    std::vector<double> us = all_ticks(days);
    std::sort(us.begin(), us.end());
    Row row;
    row.suite = "lod";
    row.scene = scene;
    row.method = method;
    row.parameter = "people=" + std::to_string(count);
    row.time_us_p50 = quantile(us, 0.5);
    row.time_us_p99 = quantile(us, 0.99);
    double active = 0.0;
    double events = 0.0;
    for (const Day& day : days) {
        active += static_cast<double>(day.active);
        events += static_cast<double>(day.events);
    }
    row.metric("tick_us_mean", mean(us));
    row.metric("awake_mean", active / static_cast<double>(us.size()));
    row.metric("events_per_tick", events / static_cast<double>(us.size()));
    return row;
}

void run_scene(Session& session, const std::string& scene) {
    const int seeds = session.quick ? 2 : 10;
    const int count = session.quick ? 100 : 1000;
    const double seconds = session.quick ? 120.0 : kDay_s;
    std::vector<Day> full;
    std::vector<Day> skipped;
    Differences differences;
    for (int seed = 1; seed <= seeds; ++seed) {
        session.progress("lod " + scene + " seed " + std::to_string(seed));
        for (const bool skip : {false, true}) {
            config::Settings settings;
            const std::string mistakes =
                read_town(scene, count, static_cast<std::uint64_t>(seed), skip, settings);
            if (!mistakes.empty()) {
                session.note("lod: config/town.txtpb could not be read: " + mistakes);
                return;
            }
            (skip ? skipped : full).push_back(DayTrial(settings).run(seconds));
        }
        differences.compare(full.back(), skipped.back(), 1.0 / 20.0);
    }
    session.note(scene +
                 ": error is the share of people with a schedule whose day differs when "
                 "nobody looks: what they did, in which order, what they had, who died");
    std::sort(differences.places_m.begin(), differences.places_m.end());
    Row row = row_of(scene, "default", skipped, count);
    row.error = static_cast<double>(differences.scheduled) / differences.people;
    row.error_unit = "share";
    row.metric("scheduled_differences", differences.scheduled);
    row.metric("arrival_difference_s_max", differences.arrival_s);
    row.metric("totals_outside_band", outside_band(full, skipped));
    row.metric("turns_compared", differences.turns);
    row.metric("dead", skipped.back().dead);
    row.metric("places_within_bound_share",
               static_cast<double>(std::upper_bound(differences.places_m.begin(),
                                                    differences.places_m.end(),
                                                    kFarBound_m) -
                                   differences.places_m.begin()) /
                   static_cast<double>(differences.places_m.size()));
    row.metric("place_difference_m_p50", quantile(differences.places_m, 0.5));
    row.metric("place_difference_m_p99", quantile(differences.places_m, 0.99));
    row.metric("place_difference_m_max", differences.places_m.back());
    Row all = row_of(scene, "simulated", full, count);
    all.error_unit = "share";
    session.add({row, all});
}

void run_lod(Session& session) {
    for (const std::string& scene : {kTownScene, kWalledScene}) {
        if (session.wants_scene(scene)) {
            run_scene(session, scene);
        }
    }
}

const Registration kLod({"lod",
                         "agents that nobody sees: the same outcome at what cost",
                         {kTownScene, kWalledScene},
                         {"default", "simulated"},
                         run_lod});

}  // namespace

}  // namespace zoned::bench
