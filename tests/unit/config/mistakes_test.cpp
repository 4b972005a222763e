// Mistakes in a config: each kind is found at its line and column, and all of them at once.
#include "server/config/expand/load_settings.h"
#include "tests/unit/config/config_helpers.h"

#include <algorithm>

namespace zoned::config::test {
namespace {

TEST(Settings, AcceptsTheTestsOwnConfig) {
    const Outcome out = parse(kValid);
    EXPECT_TRUE(out.ok);
    EXPECT_EQ(format_errors("test", out.errors), "");
}

/// A config that lacks a brace is reported once, at the block without an end.
void expect_brace(const std::string& text, const std::string& needle, const std::string& words) {
    const Outcome out = parse(text);
    ASSERT_EQ(out.errors.size(), 1U) << format_errors("test", out.errors);
    const auto [line, column] = place_of(text, needle);
    EXPECT_EQ(out.errors[0].line, line) << out.errors[0].text;
    EXPECT_NE(out.errors[0].text.find(words), std::string::npos) << out.errors[0].text;
}

TEST(Settings, NamesTheBlockThatHasNoEnd) {
    expect_brace(with("  max_z_m: 50\n}", "  max_z_m: 50\n"), "world {", "'world {' of line 1");
    expect_brace(with("max_x_m: 0 max_z_m: 50 }", "max_x_m: 0 max_z_m: 50 "),
                 "zone { name: \"west\"",
                 "'zone {' of line 9");
    expect_brace(with("ghost_margin_m: 60\n}", "ghost_margin_m: 60"), "zones {", "'zones {'");
    expect_brace(with("{ radius_m: 0.4 length_m: 1 }", "{ radius_m: 0.4 length_m: 1 "),
                 "capsule {",
                 "'capsule {'");
    expect_brace(with("position_bound_m: 0.5 }", "position_bound_m: 0.5 "),
                 "lod { position",
                 "a } is missing");
    expect_brace(with("aura_m { normal: 50 }\n}", "aura_m [ normal: 50 }\n}"),
                 "aura_m [",
                 "'aura_m [' of line");
}

TEST(Settings, NamesABraceThatClosesNothing) {
    expect_brace(
        with("spawn { x_m: 1 z_m: 2 }", "spawn { x_m: 1 z_m: 2 } }"), "spawn {", "closes nothing");
    // Braces in comments and texts are none.
    EXPECT_TRUE(parse(with("world {", "# } {\nworld {")).ok);
    const Outcome name = parse(with("name: \"test\"", "name: \"te}st\""));
    EXPECT_EQ(format_errors("test", name.errors).find("closes"), std::string::npos);
}

struct Case {
    std::string name;
    std::string from;
    std::string to;
    std::string needle;  ///< where the mistake must be reported
    std::string words;   ///< that its text must hold
};

void PrintTo(const Case& c, std::ostream* out) {
    *out << c.to;
}

class OneMistake : public testing::TestWithParam<Case> {};

TEST_P(OneMistake, IsReportedAtItsPlace) {
    expect_single(with(GetParam().from, GetParam().to), GetParam().needle, GetParam().words);
}

const Case kText[] = {
    {"Syntax", "spawn { x_m: 1", "spawn { x_m 1", "1 z_m: 2", "syntax"},
    {"DecimalComma", "spawn { x_m: 1 ", "spawn { x_m: 1,5 ", "x_m: 1,5", "write x_m: 1.5"},
    {"DecimalCommaAtTheEnd", "z_m: 2 }", "z_m: -2,25 }", "z_m: -2,25", "write z_m: -2.25"},
    {"UnknownField",
     "ghost_margin_m: 60",
     "ghost_margin_m: 60 ghost_margin: 5",
     "ghost_margin: 5",
     "did you mean 'ghost_margin_m'"},
    {"UnknownSection", "spawn {", "weather { rain: 3 } spawn {", "weather", "unknown setting"},
    {"WordForNumber",
     "min_z_m: -50\n  max_x_m",
     "min_z_m: -50\n  seed: abc\n  max_x_m",
     "seed: abc",
     "Expected integer"},
    {"NumberForText", "name: \"test\"", "name: 5", "name: 5", "Expected string"},
    {"NegativeForUnsigned",
     "name: \"test\"",
     "name: \"test\" seed: -1",
     "seed: -1",
     "Expected integer"},
    {"TooBigForItsType",
     "name: \"test\"",
     "name: \"test\" seed: 99999999999999999999",
     "seed: 9",
     "out of range"},
    {"UnknownEnumValue",
     "kind: CHARACTER",
     "kind: CHARACTR",
     "kind: CHARACTR",
     "choose one of PROP, CHARACTER"},
    {"BadBool",
     "spawn {",
     "audit { enabled: maybe } spawn {",
     "enabled: maybe",
     "neither true nor false"},
    {"GivenTwice",
     "name: \"test\"",
     "name: \"test\" name: \"again\"",
     "name: \"again\"",
     "given twice"},
    {"SectionTwice", "spawn {", "world { seed: 1 } spawn {", "world { seed", "given twice"},
    {"TwoShapes",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "box { x_m: 1 y_m: 1 z_m: 1 } sphere { radius_m: 1 }",
     "sphere",
     "only one of"},
    {"NumberForBlock", "spawn {", "ai: 5\nspawn {", "ai: 5", "Expected"},
};

const Case kRanges[] = {
    {"TickRateTooHigh",
     "name: \"test\"",
     "name: \"test\" tick_rate_hz: 1000",
     "tick_rate_hz",
     "[5..240]"},
    {"TickRateTooLow",
     "name: \"test\"",
     "name: \"test\" tick_rate_hz: 1",
     "tick_rate_hz",
     "[5..240]"},
    {"NotANumber",
     "name: \"test\"",
     "name: \"test\" ground_height_m: nan",
     "ground_height_m",
     "finite"},
    {"Infinite",
     "name: \"test\"",
     "name: \"test\" ground_height_m: -inf",
     "ground_height_m",
     "finite"},
    {"PortTooHigh", "spawn {", "network { tcp_port: 70000 }\nspawn {", "tcp_port", "65535"},
    {"EmptyName", "name: \"test\"", "name: \"\"", "name: \"\"", "0 bytes"},
    {"ThinShape", "box { x_m: 1", "box { x_m: 0", "x_m: 0 y_m: 1", "out of range"},
};

const Case kZones[] = {
    {"Overlap",
     "zone { name: \"east\" min_x_m: 0",
     "zone { name: \"east\" min_x_m: -10",
     "zone { name: \"east\"",
     "overlaps zone 'west'"},
    {"Gap",
     "zone { name: \"east\" min_x_m: 0",
     "zone { name: \"east\" min_x_m: 10",
     "zones {",
     "leave a gap: x 0..10"},
    {"SameName", "\"east\"", "\"west\"", "name: \"west\" min_x_m: 0", "name of zones.zone[0]"},
    {"Inverted",
     "max_x_m: 0 max_z_m: 50",
     "max_x_m: -200 max_z_m: 50",
     "max_x_m: -200",
     "greater than min_x_m"},
    {"NoExtent",
     "min_z_m: -50 max_x_m: 0",
     "max_x_m: 0",
     "zone { name: \"west\"",
     "needs min_x_m, min_z_m"},
    {"OutsideTheWorld",
     "max_x_m: 100 max_z_m: 50 }",
     "max_x_m: 150 max_z_m: 50 }",
     "zone { name: \"east\"",
     "outside the world"},
    {"GridAndList", "ghost_margin_m: 60", "zone_grid { }", "zone_grid", "not both"},
    {"BadName", "\"west\"", "\"we st\"", "name: \"we st\"", "letters, digits"},
};

const Case kRadii[] = {
    // 52.7 x 1.1 + 2 = 59.97 m fits into 60 m, 53 x 1.1 + 2 = 60.3 m does not.
    {"NimbusBeyondMargin",
     "nimbus_m { normal: 50 }",
     "nimbus_m { normal: 53 }",
     "nimbus_m { normal: 53 }",
     "larger than zones.ghost_margin_m"},
    {"NimbusOfOneStance",
     "nimbus_m { normal: 50 }",
     "nimbus_m { normal: 50 riding: 90 }",
     "nimbus_m { normal: 50 riding",
     "nimbus of 90 m"},
    {"RadiusOfAStanceThatIsNone",
     "nimbus_m { normal: 50 }",
     "nimbus_m { normal: 50 named { stance: \"flying\" radius_m: 9 } }",
     "stance: \"flying\"",
     "there is no stance"},
    {"LodsDescend",
     "lod { position_bound_m: 0.5 }",
     "lod { radius_m: 20 }\nlod { position_bound_m: 0.5 }",
     "radius_m: 20",
     "must ascend"},
    {"LastLodEnds",
     "lod { position_bound_m: 0.5 }",
     "lod { radius_m: 60 }",
     "radius_m: 60",
     "leave it out"},
    {"LodWithoutRadius",
     "lod { radius_m: 30 position",
     "lod { position",
     "lod { position_bound_m: 0.05",
     "radius_m is missing"},
    {"BoundBelowQuantum",
     "position_bound_m: 0.05",
     "position_bound_m: 0.005",
     "position_bound_m: 0.005",
     "finer than the quantisation"},
    {"BoundNarrowerFartherOff",
     "position_bound_m: 0.05",
     "position_bound_m: 0.6",
     "position_bound_m: 0.5",
     "a bound may only widen with the distance"},
    {"TurnNarrowerFartherOff",
     "position_bound_m: 0.5 }",
     "position_bound_m: 0.5 orientation_bound_rad: 0.05 }",
     "orientation_bound_rad: 0.05",
     "a bound may only widen with the distance"},
    {"NarrowExtent",
     "spawn {",
     "replication { quantization { horizontal_extent_m: 109 } }\nspawn {",
     "horizontal_extent_m",
     "half of the largest zone, 50, and the ghost margin, 60"},
    {"HigherThanStatesTell",
     "spawn {",
     "replication { quantization { vertical_extent_m: 110 } }\n"
     "entity { type: \"crate\" x_m: 20 y_m: 120 z_m: 3 }\nspawn {",
     "entity {",
     "stands at 120 m, farther up or down than states can tell"},
    {"LongSilence",
     "world {",
     "replication { silence_ticks: 12 }\nworld {\n  tick_rate_hz: 20",
     "silence_ticks: 12",
     "0.5 s"},
};

const Case kTypes[] = {
    {"UnknownBrain",
     "brain: \"guard\"",
     "brain: \"gard\"",
     "brain: \"gard\"",
     "no brain named 'gard'"},
    {"SameTypeName",
     "name: \"crate\"",
     "name: \"player\"",
     "name: \"player\"\n  box",
     "name of another type"},
    {"NoShape", "box { x_m: 1 y_m: 1 z_m: 1 }", "", "type {\n  name: \"crate\"", "needs a shape"},
    {"FlatHull",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "hull { point { } point { x_m: 1 } point { z_m: 1 } point { x_m: 1 z_m: 1 } }",
     "hull {",
     "plane"},
    {"HullOfThree",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "hull { point { } point { x_m: 1 } point { z_m: 1 } }",
     "point { z_m: 1 } }",
     "[4..4096]"},
    {"PartWithoutShape",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "compound { part { sphere { } } part { y_m: 1 } }",
     "compound {",
     "part 2: it needs a shape"},
    {"FlatPart",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "compound { part { hull { point { } point { } point { } point { } } } }",
     "compound {",
     "part 1:"},
    {"SingleBox",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "box { x_m: 1 y_m: 1 z_m: 1 }\n  representation { single_beyond_m: 50 }",
     "single_beyond_m",
     "only a compound"},
    {"HullOnPins",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "soft { rope { } }\n  representation { single_beyond_m: 50 }",
     "single_beyond_m",
     "does not hang on pins"},
    {"ParticleWithinHearing",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "box { x_m: 1 y_m: 1 z_m: 1 }\n  representation { particle_beyond_m: 50 }",
     "particle_beyond_m",
     "players hear of it"},
    {"SoftWithoutForm",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "soft { }",
     "soft {",
     "needs a form: cloth"},
    {"SoftCharacter",
     "kind: CHARACTER\n  capsule { radius_m: 0.4 length_m: 1 }\n  brain",
     "kind: CHARACTER\n  soft { jelly { } }\n  brain",
     "type {\n  name: \"guard\"",
     "no other shape"},
    {"PinBesideTheCloth",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "soft { cloth { columns: 5 pin { column: 5 } } }",
     "soft {",
     "pin 1: the cloth has no node there"},
    {"PointsInOnePlaceOfARope",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "soft { rope { length_m: 0.01 nodes: 4096 } thickness_m: 0.5 self_collision: true }",
     "thickness_m",
     "push each other apart"},
    {"SoftNodesTooLight",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "soft { jelly { nodes_x: 32 nodes_y: 32 nodes_z: 32 } }\n  mass_kg: 0.00001",
     "mass_kg: 0.00001",
     "0.001"},
    {"YieldAboveTear",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "soft { jelly { } yield_strain: 2 tear_strain: 1 }",
     "yield_strain",
     "tears before it yields"},
    {"CollapsingBalloon",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "soft { balloon { gas_pressure_pa: 90000 } }",
     "gas_pressure_pa",
     "collapses"},
    {"StiffnessOfZero",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "soft { cloth { stiffness_npm: 0 } }",
     "stiffness_npm: 0",
     "[0.001.."},
    {"BouncingJelly",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "soft { jelly { } }\n  restitution: 0.5",
     "restitution",
     "soft body has none"},
    {"SoftAsAPoint",
     "box { x_m: 1 y_m: 1 z_m: 1 }",
     "soft { jelly { } }\n  representation { particle_beyond_m: 500 }",
     "particle_beyond_m",
     "never simulated as a point"},
    {"SolidCharacter",
     "kind: CHARACTER\n  capsule { radius_m: 0.4 length_m: 1 }\n  brain",
     "kind: CHARACTER\n  compound { part { sphere { } } }\n  brain",
     "type {\n  name: \"guard\"",
     "no other shape"},
    {"BoxyCharacter",
     "kind: CHARACTER\n  capsule { radius_m: 0.4 length_m: 1 }\n  brain",
     "kind: CHARACTER\n  box { }\n  brain",
     "type {\n  name: \"guard\"",
     "no other shape"},
    {"PropWithAnAgent",
     "box { x_m: 1",
     "brain: \"guard\" box { x_m: 1",
     "brain: \"guard\" box",
     "only characters"},
    {"PropThatWalks",
     "box { x_m: 1",
     "character { } box { x_m: 1",
     "character { }",
     "CHARACTER only"},
    {"LimitBelowGravity",
     "box { x_m: 1",
     "max_acceleration_mps2: 5 box { x_m: 1",
     "max_acceleration_mps2: 5",
     "gravity"},
    {"LimitBelowOwnAcceleration",
     "brain: \"guard\"",
     "brain: \"guard\" max_acceleration_mps2: 19.5",
     "max_acceleration_mps2: 19.5",
     "own acceleration, 20"},
    {"JumpBeyondLimit",
     "brain: \"guard\"",
     "brain: \"guard\" max_velocity_jump_mps: 3",
     "max_velocity_jump_mps: 3",
     "jump_speed_mps, 5"},
    {"UnknownState", "to: \"chase\"", "to: \"chas\"", "to: \"chas\"", "no state named 'chas'"},
    {"NoStates",
     "spawn {",
     "brain { name: \"empty\" }\nspawn {",
     "brain { name: \"empty\"",
     "there are 0 of state"},
    {"SameStateName",
     "state { name: \"chase\" action: CHASE",
     "state { name: \"chase\" }\n  state { name: \"chase\" action: CHASE",
     "name: \"chase\" action",
     "name of another state"},
    {"SameBrainName",
     "spawn {",
     "brain { name: \"guard\" state { name: \"a\" } }\nspawn {",
     "name: \"guard\" state { name: \"a\"",
     "name of another brain"},
    {"BeyondPerception", "threshold: 20", "threshold: 50", "threshold: 50", "perception_m, 40"},
};

const Case kPlaces[] = {
    {"SpawnOutside", "spawn { x_m: 1", "spawn { x_m: 101", "spawn {", "outside the world"},
    {"SpawnWithoutZ", "x_m: 1 z_m: 2", "x_m: 1", "spawn {", "needs x_m and z_m"},
    {"SpawnOnAnEdge",
     "spawn {",
     "statics { box { x_m: 1.3 y_m: 1 z_m: 2 } }\nspawn {",
     "spawn {",
     "not level"},
    {"EntityOutside",
     "spawn {",
     "entity { type: \"crate\" x_m: 500 z_m: 0 }\nspawn {",
     "entity {",
     "outside the world"},
    {"EntityOfUnknownType",
     "spawn {",
     "entity { type: \"crat\" x_m: 5 z_m: 0 }\nspawn {",
     "type: \"crat\" ",
     "no type named 'crat'"},
    {"EntityInABox",
     "spawn {",
     "statics { box { x_m: 20 y_m: 2 size { x_m: 4 y_m: 4 z_m: 4 } } }\n"
     "entity { type: \"crate\" x_m: 20 y_m: 1 z_m: 0 }\nspawn {",
     "entity {",
     "inside a static box"},
    {"EntityUnderground",
     "spawn {",
     "entity { type: \"crate\" x_m: 5 y_m: 0.2 z_m: 0 }\nspawn {",
     "entity {",
     "below the ground"},
    {"ScatterOfUnknownType",
     "spawn {",
     "scatter { type: \"nix\" }\nspawn {",
     "type: \"nix\"",
     "no type named 'nix'"},
    {"ScatterOutside",
     "spawn {",
     "scatter { type: \"crate\" region { min_x_m: 50 min_z_m: 0 max_x_m: 150 max_z_m: 9 } }\n"
     "spawn {",
     "region {",
     "outside the world"},
    {"ScatterWithoutRoom",
     "spawn {",
     "scatter { type: \"crate\" count: 50 region { min_x_m: 50 min_z_m: 0 max_x_m: 55 max_z_m: 5 "
     "} }\nspawn {",
     "scatter {",
     "of 50 'crate' find a free and level place"},
    {"BoxOutside",
     "spawn {",
     "statics { box { x_m: 200 } }\nspawn {",
     "box { x_m: 200",
     "outside the world"},
    {"SteepRamp",
     "spawn {",
     "statics { hill { terraces: 2 terrace_height_m: 4 terrace_depth_m: 5 } }\nspawn {",
     "terrace_depth_m: 5",
     "does not fit"},
    {"PointlessWall",
     "spawn {",
     "statics { wall { point { x_m: 9 z_m: 9 } point { x_m: 9 z_m: 9 } } }\nspawn {",
     "point { x_m: 9 z_m: 9 } }",
     "same point"},
};

const Case kServer[] = {
    {"BadAddress",
     "spawn {",
     "network { bind_address: \"localhost\" }\nspawn {",
     "bind_address",
     "no IPv4 or IPv6 address"},
    {"SamePorts",
     "spawn {",
     "network { tcp_port: 7000 admin_port: 7000 }\nspawn {",
     "admin_port",
     "same as tcp_port"},
    {"SamePortForWebSockets",
     "spawn {",
     "network { tcp_port: 7000 websocket_port: 7000 }\nspawn {",
     "websocket_port",
     "same as tcp_port"},
    {"WebSocketAddress",
     "spawn {",
     "network { websocket_port: 0 websocket_address: \"localhost\" }\nspawn {",
     "websocket_address",
     "no IPv4 or IPv6 address"},
    {"OriginWithoutAPort",
     "spawn {",
     "network { websocket_origin: \"https://play.example\" }\nspawn {",
     "websocket_origin",
     "needs network.websocket_port"},
    {"OriginWithAPath",
     "spawn {",
     "network { websocket_port: 0 websocket_origin: \"https://play.example/\" }\nspawn {",
     "websocket_origin",
     "is no origin"},
    {"AdminKeyWithoutCertificate",
     "spawn {",
     "network { admin_key_file: \"/dev/null\" }\nspawn {",
     "admin_key_file",
     "needs network.admin_certificate_file"},
    {"UnknownLogArea",
     "spawn {",
     "log { level { area: \"sessions\" } }\nspawn {",
     "area",
     "no area of the log; there are server, session"},
    {"LogAreaTwice",
     "spawn {",
     "log { level { area: \"tick\" }\nlevel { area:  \"tick\" } }\nspawn {",
     "area:  ",
     "given twice"},
    {"UnknownBrokenZone",
     "spawn {",
     "testing { break_zone { zone: \"nowhere\" } }\nspawn {",
     "zone: \"nowhere",
     "no zone named 'nowhere'"},
    {"KeyWithoutCertificate",
     "dev_mode_loopback: true",
     "dev_mode_loopback: true\ntls_key_file: \"/dev/null\"",
     "tls_key_file",
     "needs session.tls_certificate_file"},
    {"MissingTicketKey",
     "dev_mode_loopback: true",
     "dev_mode_loopback: true\nticket_public_key_file: \"/nonexistent/key\"",
     "ticket_public_key_file",
     "cannot read '/nonexistent/key'"},
    {"NobodyCanLogIn", "dev_mode_loopback: true", "grace_s: 5", "session {", "nobody can log in"},
    {"NobodyMayPlay",
     "dev_mode_loopback: true",
     "dev_mode_loopback: true\ndev_rights: AUDIT",
     "dev_rights",
     "nobody can log in: without PLAY"},
    {"NobodyReachesTheEntrance",
     "spawn {",
     "network { bind_address: \"192.0.2.1\" }\nspawn {",
     "bind_address",
     "nobody can log in: the development mode lets in loopback addresses only"},
    {"UnknownStalledZone",
     "spawn {",
     "testing { stall_zone { zone: \"north\" } }\nspawn {",
     "zone: \"north\"",
     "no zone named 'north'"},
    {"UnknownLimitedType",
     "spawn {",
     "testing { wrong_limit { type: \"x\" } }\nspawn {",
     "type: \"x\"",
     "no type named 'x'"},
    {"RuleTwice",
     "spawn {",
     "rules { name: \"health\" value: \"1\" }\nrules { name: \"health\" value: \"2\" }\nspawn {",
     "name: \"health\" value: \"2\"",
     "given twice"},
};

std::string name_of(const testing::TestParamInfo<Case>& info) {
    return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Text, OneMistake, testing::ValuesIn(kText), name_of);
INSTANTIATE_TEST_SUITE_P(Ranges, OneMistake, testing::ValuesIn(kRanges), name_of);
INSTANTIATE_TEST_SUITE_P(Zones, OneMistake, testing::ValuesIn(kZones), name_of);
INSTANTIATE_TEST_SUITE_P(Radii, OneMistake, testing::ValuesIn(kRadii), name_of);
INSTANTIATE_TEST_SUITE_P(Types, OneMistake, testing::ValuesIn(kTypes), name_of);
INSTANTIATE_TEST_SUITE_P(PointsOfInterest, OneMistake, testing::ValuesIn(kPlaces), name_of);
INSTANTIATE_TEST_SUITE_P(Server, OneMistake, testing::ValuesIn(kServer), name_of);

TEST(Settings, NamesEveryAuraAndNimbusThatAGhostMarginCutsOff) {
    // 50 m x 1.1 + 6 m = 61 m: the player's nimbus and the auras that it would hear.
    const Outcome out =
        parse(with("ghost_margin_m: 60", "ghost_margin_m: 60 handoff_hysteresis_m: 6"));
    ASSERT_EQ(out.errors.size(), 3u) << format_errors("test", out.errors);
    EXPECT_EQ(out.errors[0].path, "type[0].aura_m");
    EXPECT_EQ(out.errors[1].path, "type[0].nimbus_m");
    EXPECT_EQ(out.errors[2].path, "type[1].aura_m");
    EXPECT_TRUE(parse(with("ghost_margin_m: 60", "ghost_margin_m: 60 handoff_hysteresis_m: 5")).ok);
}

TEST(Settings, LetSomebodyInByLoopbackOrByTicket) {
    for (const char* address : {"127.0.0.1", "127.8.9.1", "0.0.0.0", "::", "::1"}) {
        const Outcome out =
            parse(kValid, {"network.bind_address=\"" + std::string(address) + "\""});
        EXPECT_TRUE(out.ok) << address << ": " << format_errors("test", out.errors);
    }
    // Any file listed as a key counts; whether it holds one is checked elsewhere.
    const Outcome out = parse(kValid,
                              {"session.dev_mode_loopback=false",
                               "network.bind_address=\"192.0.2.1\"",
                               "session.ticket_public_key_file=\"/dev/null\""});
    EXPECT_TRUE(out.ok) << format_errors("test", out.errors);
}

TEST(Settings, LetsRadiiBeAsLargeAsTheyLikeInASingleZone) {
    std::string text = with("ghost_margin_m: 60", "zone_grid { }");
    for (const char* zone : {"west", "east"}) {
        const std::size_t at = text.find("  zone { name: \"" + std::string(zone));
        text.erase(at, text.find('\n', at) + 1 - at);
    }
    EXPECT_TRUE(parse(with("nimbus_m { normal: 50 }", "nimbus_m { normal: 900 }", text)).ok);
}

TEST(Settings, ReportsAllMistakesOfAFileAtOnceInOrderOfLine) {
    std::string text = with("name: \"test\"", "name: \"test\" tickrate: 3");
    text = with("min_x_m: -100\n", "min_x_m: abc\n", text);
    text = with("zone { name: \"east\" min_x_m: 0", "zone { name: \"east\" min_x_m: -10", text);
    text = with("nimbus_m { normal: 50 }", "nimbus_m { normal: 80 }", text);
    text = with("brain: \"guard\"", "brain: \"gard\"", text);
    text = with("to: \"chase\"", "to: \"chas\"", text);
    text = with("spawn { x_m: 1", "spawn { x_m: 60000", text);
    text += "spawn { x_m: 300 z_m: 0 }\nscatter { type: \"nix\" }\nnonsense: 1\n";
    const Outcome out = parse(text);
    EXPECT_FALSE(out.ok);
    const std::string all = format_errors("test", out.errors);
    for (const char* words : {"unknown setting in World",
                              "Expected double",
                              "overlaps zone 'west'",
                              "larger than zones.ghost_margin_m",
                              "no brain named 'gard'",
                              "no state named 'chas'",
                              "60000 is out of range",
                              "spawn point outside the world",
                              "no type named 'nix'",
                              "unknown setting in the config"}) {
        EXPECT_NE(all.find(words), std::string::npos) << words << " is not in\n" << all;
    }
    EXPECT_EQ(out.errors.size(), 10u) << all;
    EXPECT_TRUE(std::is_sorted(
        out.errors.begin(), out.errors.end(), [](const ConfigError& a, const ConfigError& b) {
            return a.line < b.line;
        }));
}

TEST(Settings, ReportsWhatStandsBeforeASyntaxErrorToo) {
    const std::string text = with("spawn {", "=\nspawn {", with("name: \"test\"", "nam: \"test\""));
    const Outcome out = parse(text);
    ASSERT_EQ(out.errors.size(), 2u) << format_errors("test", out.errors);
    EXPECT_EQ(out.errors[0].line, 2);
    EXPECT_EQ(out.errors[1].line, place_of(text, "=\nspawn").first);
}

TEST(Settings, NamesTheFileThatCannotBeRead) {
    Settings settings;
    std::vector<ConfigError> errors;
    EXPECT_FALSE(load_settings("/nonexistent/world.txtpb", {}, settings, errors));
    ASSERT_EQ(errors.size(), 1u);
    EXPECT_NE(errors[0].text.find("No such file"), std::string::npos);
    EXPECT_FALSE(load_settings("/tmp", {}, settings, errors));
    ASSERT_EQ(errors.size(), 1u);
}

TEST(Settings, CountsColumnsBehindTabsAsTheParserDoes) {
    const std::string text = with("ghost_margin_m: 60", "\tghost_margin_m: \"x\"");
    const Outcome out = parse(text);
    ASSERT_EQ(out.errors.size(), 1u) << format_errors("test", out.errors);
    EXPECT_EQ(out.errors[0].line, place_of(text, "ghost_margin_m").first);
    EXPECT_EQ(out.errors[0].column, 9) << "two spaces and a tab lead to the ninth column";
    const Outcome range = parse(with("ghost_margin_m: 60", "\tghost_margin_m: 0"));
    ASSERT_EQ(range.errors.size(), 1u) << format_errors("test", range.errors);
    EXPECT_EQ(range.errors[0].column, 9) << "the same for what is found after parsing";
    EXPECT_NE(out.errors[0].text.find("Expected double"), std::string::npos);
}

}  // namespace
}  // namespace zoned::config::test
