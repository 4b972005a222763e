#include "tests/bench/physics_scene_list.h"

#include "tests/scenario/hull_scenes.h"
#include "tests/scenario/impact_scenes.h"
#include "tests/scenario/joint_scenes.h"

#include <cstdio>

namespace zoned::bench {

namespace {

using scenario::Description;
using Scenes = std::vector<PhysicsScene>;

constexpr double kFrame = 1.0 / 60.0;

std::string plain(double x) {
    char text[32];
    std::snprintf(text, sizeof(text), "%g", x);
    return text;
}

std::vector<PhysicsCase> one(std::function<Description()> describe) {
    return {{"", std::move(describe)}};
}

void add_known(Scenes& s, bool quick) {
    using namespace scenario;
    s.push_back({"S1", "", one(pyramid), drift_meter, 60});
    s.push_back({"S2", "", one([] { return column(20, 1.0); }), drift_meter, 120});
    s.push_back({"S2x100", "", one([] { return column(5, 100.0); }), column_meter, 120});
    s.push_back({"S2x1000", "", one([] { return column(5, 1000.0); }), column_meter, 120});
    s.push_back({"S3", "", one([] { return pile(16); }), pile_meter, 20, 0, false});
    // Bullet lets bodies sleep after two seconds at the earliest, so timing starts after three.
    const int side = quick ? 30 : 100;
    s.push_back({"S4", "", one([side] { return resting_field(side); }), drift_meter, 200, 180});
    const auto ball = [](double e, double seconds, int fine) {
        return one([=] { return bounce(e, seconds, kFrame / fine); });
    };
    s.push_back({"S5", "dt=1/60", ball(1.0, 60.0, 1), last_apex_meter, 600});
    s.push_back({"S5", "dt=1/240", ball(1.0, 60.0, 4), last_apex_meter, 2400});
    s.push_back({"S5b", "dt=1/60", ball(0.8, 20.0, 1), apexes_meter, 1200});
    s.push_back({"S5b", "dt=1/240", ball(0.8, 20.0, 4), apexes_meter, 4800});
    s.push_back({"S6a", "", one([] { return incline(0.5, 3.0); }), slide_meter, 180});
    s.push_back({"S6b", "", one([] { return incline(0.6, 10.0); }), creep_meter, 120});
    s.push_back({"S7", "", one(spin), spin_meter, 600});
    s.push_back({"S8", "", one(chain), chain_meter, 120});
    s.push_back({"S9", "", one(bullets), bullets_meter, 60});
}

void add_joints(Scenes& s, bool quick) {
    using namespace scenario;
    PhysicsScene pairs{"S11", "pair", {}, drop_meter, 60, 0, false};
    for (const double ratio : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 1000.0}) {
        pairs.cases.push_back({"ratio_" + plain(ratio), [ratio] {
                                   return fixed_pair(ratio);
                               }});
    }
    s.push_back(pairs);
    for (const double height : {0.01, 0.1, 1.0}) {
        PhysicsScene boxes{
            "S11", "wheels from " + plain(height) + " m", {}, drop_meter, 60, 0, false};
        for (const double ratio : {1.0, 5.0, 20.0, 50.0, 100.0, 200.0}) {
            boxes.cases.push_back({"ratio_" + plain(ratio), [ratio, height] {
                                       return wheeled_box(ratio, height);
                                   }});
        }
        s.push_back(boxes);
    }
    for (const bool mesh : {true, false}) {
        PhysicsScene cars{"S12", mesh ? "mesh" : "box", {}, car_meter, 60, 0, false};
        for (int seed = 0; seed <= 4; ++seed) {
            cars.cases.push_back(
                {seed == 0 ? "as_given" : "seed_" + std::to_string(seed), [mesh, seed] {
                     return car(mesh, seed);
                 }});
        }
        s.push_back(cars);
    }
    for (const int count : {1, 100}) {
        s.push_back({"S13",
                     std::to_string(count),
                     one([count] { return ragdolls(count); }),
                     ragdoll_meter,
                     count == 1 ? 120 : 10,
                     0,
                     false});
    }
    for (const int side : {12, 20, 40}) {
        if (!quick || side == 12) {
            s.push_back({"S14",
                         std::to_string(side) + " x " + std::to_string(side),
                         one([side] { return sheet(side); }),
                         sheet_meter,
                         10,
                         0,
                         false,
                         false});
        }
    }
}

void add_impacts(Scenes& s) {
    using namespace scenario;
    for (const double e : {0.0, 0.25, 0.5, 0.75, 0.9, 1.0}) {
        PhysicsScene rows{"S15", "row e=" + plain(e), {}, row_meter, 120, 0, false};
        for (const double gap : {0.0, 0.001, 0.01, 0.1}) {
            for (int n = 2; n <= 8; ++n) {
                rows.cases.push_back({"n_" + std::to_string(n) + "_gap_" + plain(gap), [n, gap, e] {
                                          return row_of_balls(n, gap, e);
                                      }});
            }
        }
        s.push_back(rows);
    }
    s.push_back({"S15", "cradle", one(cradle), cradle_meter, 120, 0, false});
    for (const double e : {0.9, 1.0}) {
        s.push_back({"S15",
                     "break e=" + plain(e),
                     one([e] { return billiard_break(e); }),
                     break_meter,
                     120,
                     0,
                     false});
    }
}

void add_cards(Scenes& s) {
    const auto add = [&s](const std::string& parameter, const scenario::CardHouse& house) {
        s.push_back({"S16",
                     parameter,
                     one([house] { return house_of_cards(house); }),
                     card_meter,
                     60,
                     0,
                     false});
    };
    add("friction 0.7", {});
    for (const double friction : {0.5, 0.6, 0.9}) {
        add("friction " + plain(friction), {.friction = friction});
    }
    for (const double mm : {2.0, 5.0}) {
        add("t = " + plain(mm) + " mm", {.half_thickness = 1e-3 * mm});
    }
    for (const double x : {300.0, 1000.0}) {
        add(plain(x) + " m out", {.x = x});
    }
    add("dt=1/30", {.dt = 1.0 / 30.0});
}

void add_hulls(Scenes& s, bool quick) {
    using namespace scenario;
    const int hulls = quick ? 100 : 2000;
    const int trees = quick ? 5 : 50;
    const int side = quick ? 6 : 21;
    const int boxes = quick ? 100 : 1000;
    const auto add = [&s](const char* name, const char* what, auto describe, int quick_steps) {
        s.push_back({name, what, one(describe), hull_meter, quick_steps, 0, false});
    };
    add(
        "S17a", "funnel", [hulls] { return hull_funnel(hulls); }, 30);
    add(
        "S17b", "trees", [trees] { return rolling_trees(trees); }, 60);
    add(
        "S17c", "mixed", [side] { return mixed_on_mesh(side); }, 60);
    // Bullet lets bodies sleep after two seconds at the earliest.
    s.push_back({"S18",
                 "",
                 one([boxes] { return static_field(boxes); }),
                 static_field_meter,
                 240,
                 210,
                 false,
                 false});
}

}  // namespace

std::vector<PhysicsScene> physics_scenes(bool quick) {
    Scenes s;
    add_known(s, quick);
    add_joints(s, quick);
    add_impacts(s);
    add_cards(s);
    add_hulls(s, quick);
    return s;
}

}  // namespace zoned::bench
