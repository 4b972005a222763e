// --set: every setting can be given on the command line, and mistakes in one are reported.
#include "server/config/text/config_set.h"

#include "tests/unit/config/config_helpers.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/text_format.h>

namespace zoned::config::test {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

TEST(Set, ReplacesASingleSetting) {
    const Outcome out = parse(kValid, {"world.tick_rate_hz=60", "world.name=other"});
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.tick_rate_hz, 60.0);
    EXPECT_EQ(out.settings.config->world().name(), "other");
    EXPECT_FLOAT_EQ(out.settings.replication.tick_s, 1.0F / 60.0F);
}

TEST(Set, NamesElementsOfListsByIndexOrName) {
    const Outcome out = parse(kValid,
                              {"zones.zone[1].name=sunrise",
                               "type[crate].mass_kg=12",
                               "brain[guard].state[chase].speed_factor=0.5",
                               "lod[0].position_bound_m=0.1"});
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.zones[1].name, "sunrise");
    EXPECT_EQ(out.settings.types[1].mass, 12.0F);
    EXPECT_EQ(out.settings.ai.brains[0].states[1].speed_factor, 0.5F);
    EXPECT_EQ(out.settings.replication.lods[0].position_m, 0.1F);
}

TEST(Set, AppendsWithTheIndexAfterTheLast) {
    const Outcome out = parse(kValid, {"spawn[1].x_m=7", "spawn[1].z_m=8"});
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.spawn_points.size(), 2u);
    EXPECT_EQ(out.settings.spawn_points[1].position.x(), 7.0);
}

TEST(Set, TakesBlocksListsAndTextWithSpecialSigns) {
    const Outcome out = parse(kValid,
                              {"testing.stall_zone={zone: \"west\" at_tick: 9}",
                               "session.dev_mode_loopback=true",
                               "session.dev_rights=PLAY,AUDIT",
                               "rules[0]={name: \"motto\"}",
                               "rules[motto].value=a=b, [c] \"d\""});
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.config->testing().stall_zone().at_tick(), 9u);
    EXPECT_EQ(out.settings.config->session().dev_rights_size(), 2);
    ASSERT_EQ(out.settings.rules.size(), 1u);
    EXPECT_EQ(out.settings.rules[0].second, "a=b, [c] \"d\"");
}

TEST(Set, ReplacesAWholeElementInItsPlace) {
    const Outcome out = parse(kValid, {"spawn[0]={x_m: 9 z_m: 9}", "spawn[1]={x_m: 3 z_m: 3}"});
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.spawn_points.size(), 2u);
    EXPECT_EQ(out.settings.spawn_points[0].position.x(), 9.0);
}

TEST(Set, ClearsWithAnEmptyValue) {
    const std::string text = with("spawn {", "replication { heartbeat_ticks: 5 }\nspawn {");
    EXPECT_EQ(parse(text).settings.replication.heartbeat_ticks, 5u);
    const Outcome out = parse(text, {"replication.heartbeat_ticks="});
    ASSERT_TRUE(out.ok);
    EXPECT_EQ(out.settings.replication.heartbeat_ticks, 60u);
}

TEST(Set, TakesElementsOutOfListsWithAnEmptyValue) {
    const Outcome out = parse(kValid,
                              {"spawn[1]={x_m: 3 z_m: 3}",
                               "spawn[2]={x_m: 4 z_m: 4}",
                               "spawn[0]=",
                               "spawn[1]=",
                               "session.dev_rights=AUDIT,PLAY",
                               "session.dev_rights[0]=",
                               "rules[0]={name: \"motto\"}",
                               "rules[motto]="});
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.spawn_points.size(), 1u);
    EXPECT_EQ(out.settings.spawn_points[0].position.x(), 3.0);
    ASSERT_EQ(out.settings.config->session().dev_rights_size(), 1);
    EXPECT_EQ(out.settings.config->session().dev_rights(0), proto::config::PLAY);
    EXPECT_TRUE(out.settings.rules.empty());
}

/// Elements behind one that is taken out are not where their paths said.
TEST(Set, ReportsNoPlaceInAListOutOfWhichAnElementWasTaken) {
    const std::string text = with("spawn {", "rules { name: \"a\" }\nrules { }\nspawn {");
    ASSERT_GT(parse(text).errors.at(0).line, 0);
    const Outcome out = parse(text, {"rules[a]="});
    ASSERT_EQ(out.errors.size(), 1u) << format_errors("test", out.errors);
    EXPECT_EQ(out.errors[0].line, 0) << format_errors("test", out.errors);
}

TEST(Set, AppliesInOrder) {
    EXPECT_EQ(parse(kValid, {"world.seed=1", "world.seed=2"}).settings.seed, 2u);
}

struct Wrong {
    std::string set;
    std::string path;
    std::string words;
};

TEST(Set, SaysWhatIsWrong) {
    const Wrong cases[] = {
        {"world.tickrate=5", "world.tickrate", "did you mean 'tick_rate_hz'"},
        {"wrld.seed=5", "wrld.seed", "did you mean 'world'"},
        {"world.seed", "world.seed", "needs path=value"},
        {"=5", "", "is not a path"},
        {"world..seed=5", "world..seed", "is not a path"},
        {"spawn[0.x_m=5", "spawn[0.x_m=5", "path"},
        {"world.seed=abc", "world.seed", "Expected integer"},
        {"world.seed=-1", "world.seed", "is not a value"},
        {"world[0].seed=1", "world[0].seed", "is not a list"},
        {"world.seed[0]=1", "world.seed[0]", "is not a list"},
        {"spawn.x_m=1", "spawn.x_m", "spawn[0]"},
        {"spawn[5].x_m=1", "spawn[5].x_m", "1 elements"},
        {"spawn[-1].x_m=1", "spawn[-1].x_m", "is named '-1'"},
        {"spawn[1]=", "spawn[1]", "there is no [1] to take out"},
        {"type[ghost]=", "type[ghost]", "no type is named 'ghost'"},
        {"type[ghost].mass_kg=1", "type[ghost].mass_kg", "no type is named 'ghost'"},
        {"world.seed.x=1", "world.seed.x", "nothing below"},
        {"type[0].kind=ROCK", "type[0].kind", "choose one of PROP, CHARACTER"},
        {"audit.enabled=yes", "audit.enabled", "yes"},
        {"world={seed: x}", "world", "Expected integer"},
    };
    for (const Wrong& wrong : cases) {
        SCOPED_TRACE(wrong.set);
        const Outcome out = parse(kValid, {wrong.set});
        ASSERT_EQ(out.errors.size(), 1u) << format_errors("test", out.errors);
        EXPECT_EQ(out.errors[0].line, 0);
        EXPECT_EQ(out.errors[0].path, wrong.path);
        EXPECT_NE(out.errors[0].text.find(wrong.words), std::string::npos) << out.errors[0].text;
    }
}

TEST(Set, ReportsAValueOutOfRangeWithoutAPlaceInTheFile) {
    const std::string text = with("name: \"test\"", "name: \"test\" tick_rate_hz: 30");
    const Outcome out = parse(text, {"world.tick_rate_hz=999"});
    ASSERT_EQ(out.errors.size(), 1u) << format_errors("test", out.errors);
    EXPECT_EQ(out.errors[0].line, 0);
    EXPECT_EQ(out.errors[0].path, "world.tick_rate_hz");
}

/// A value within the field's range that differs from its default.
std::string sample_value(const FieldDescriptor& field) {
    const proto::FieldRange& range = field.options().GetExtension(proto::range);
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_STRING:
            return "text";
        case FieldDescriptor::CPPTYPE_BOOL:
            return field.default_value_bool() ? "false" : "true";
        case FieldDescriptor::CPPTYPE_ENUM:
            return field.enum_type()->value(field.enum_type()->value_count() - 1)->name();
        default:
            return std::to_string(static_cast<long>(range.max() > 1e15 ? 77.0 : range.max()));
    }
}

/// Sets each leaf below `message` through its path and looks whether the config changed.
void set_every_leaf(const google::protobuf::Descriptor& message,
                    const std::string& path,
                    int& leaves) {
    for (int i = 0; i < message.field_count(); ++i) {
        const FieldDescriptor& field = *message.field(i);
        const std::string here = join_path(path, field.name(), field.is_repeated() ? 0 : -1);
        if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
            set_every_leaf(*field.message_type(), here, leaves);
            continue;
        }
        SCOPED_TRACE(here);
        proto::config::Config config;
        Diagnostics diagnostics;
        apply_set(here + "=" + sample_value(field), config, diagnostics);
        EXPECT_TRUE(diagnostics.empty()) << format_errors("", diagnostics.sorted());
        EXPECT_GT(config.ByteSizeLong(), 0u);
        ++leaves;
    }
}

TEST(Set, ReachesEverySettingOfTheSchema) {
    int leaves = 0;
    set_every_leaf(*proto::config::Config::descriptor(), "", leaves);
    EXPECT_GT(leaves, 150);
}

}  // namespace
}  // namespace zoned::config::test
