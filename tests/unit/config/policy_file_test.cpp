#include "server/config/training/policy_file.h"

#include "server/config/expand/load_settings.h"
#include "server/config/training/training_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace zoned::config {
namespace {

namespace learning = ai::learning;

learning::Policy some_policy(std::uint64_t seed) {
    learning::Policy policy;
    policy.name = "some";
    policy.facing = learning::Facing::kHome;
    policy.inputs = {{learning::Ego::kHomeDistance, "", 0.1F, -1.0F},
                     {learning::Ego::kTargetDistance, "hunger", 1.0F / 3.0F, 0.0F}};
    policy.network =
        learning::dense(std::array<std::size_t, 3>{2, 5, 2}, learning::Activation::kLinear);
    core::Rng rng(seed);
    randomise(policy.network, rng);
    return policy;
}

TEST(PolicyFile, GivesBackEveryBit) {
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        const learning::Policy policy = some_policy(seed);
        const auto back = parse_policy(policy_text(policy, "by hand"));
        ASSERT_TRUE(back.ok()) << back.error();
        EXPECT_EQ(back->network, policy.network);
        EXPECT_EQ(back->name, policy.name);
        EXPECT_EQ(back->facing, policy.facing);
        ASSERT_EQ(back->inputs.size(), 2u);
        EXPECT_EQ(back->inputs[0].scale, 0.1F);
        EXPECT_EQ(back->inputs[1].variable, "hunger");
        EXPECT_EQ(back->inputs[1].scale, 1.0F / 3.0F);
    }
}

TEST(PolicyFile, IsRefusedAfterAnyChangeOfItsMeaning) {
    const std::string text = policy_text(some_policy(1), "by hand");
    int changed = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] < '0' || text[i] > '8') {
            continue;
        }
        std::string other = text;
        ++other[i];
        ++changed;
        // Digits of the digest, of the version, of weights: the last digit of a float may round to
        // the same one, and then nothing has changed.
        const auto read = parse_policy(other);
        EXPECT_TRUE(!read.ok() || read->network == parse_policy(text)->network) << other;
    }
    EXPECT_GT(changed, 200);
    EXPECT_NE(parse_policy("").error(), "");
    EXPECT_NE(parse_policy("version: 1 nonsense").error(), "");
    const std::string newer = "version: 2" + text.substr(10);
    EXPECT_NE(parse_policy(newer).error().find("version 2"), std::string::npos);
}

TEST(PolicyFile, OfATaskWithoutMovementIsNotFollowed) {
    learning::Policy policy;
    policy.name = "pole";
    policy.network = learning::dense(std::array<std::size_t, 2>{4, 1});
    const auto read = parse_policy(policy_text(policy, ""));
    ASSERT_FALSE(read.ok());
    EXPECT_NE(read.error().find("inputs"), std::string::npos) << read.error();
}

std::string policy_folder() {
    const std::string path = std::filesystem::temp_directory_path().string() + "/zoned_policies_" +
                             ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
    return path;
}

void put_text(const std::string& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

/// The minimal world whose wanderers follow a policy.
std::string world_with_policy(const std::string& policy_settings) {
    std::ifstream in(ZONED_SOURCE_DIR "/config/minimal.txtpb");
    std::stringstream text;
    text << in.rdbuf();
    std::string world = text.str();
    const std::string walk = "action: WANDER speed_factor: 0.6 radius_m: 15";
    world.replace(world.find(walk), walk.size(), "policy: \"learned\" speed_factor: 0.6");
    world.insert(world.find("brain {\n") + 10, "  variable { name: \"hunger\" per_s: 0.01 }\n");
    return world + "\npolicy { name: \"learned\" " + policy_settings + " }\n";
}

std::string mistakes_in_world(const std::string& file) {
    Settings settings;
    std::vector<ConfigError> errors;
    load_settings(file, {}, settings, errors);
    return format_errors("world", errors);
}

TEST(PoliciesOfAConfig, AreLoadedBoundAndPartOfItsText) {
    const std::string here = policy_folder();
    put_text(here + "/p.policy", policy_text(some_policy(3), ""));
    put_text(here + "/world.txtpb",
             world_with_policy("file: \"p.policy\" max_home_m: 15 max_turn_degps: 180"));
    ASSERT_EQ(mistakes_in_world(here + "/world.txtpb"), "");
    Settings settings;
    std::vector<ConfigError> errors;
    ASSERT_TRUE(load_settings(here + "/world.txtpb", {}, settings, errors));
    const ai::CompiledBrain& brain = settings.ai.compiled[0];
    const auto& choice = std::get<ai::PolicyChoice>(brain.states[0].choice);
    EXPECT_EQ(choice.policy->policy.network, some_policy(3).network);
    EXPECT_FLOAT_EQ(choice.policy->guard.max_turn_radps, 3.14159265F);
    EXPECT_FLOAT_EQ(choice.policy->guard.max_home_m, 15.0F);
    EXPECT_EQ(choice.variable, (std::vector<std::uint16_t>{0, 0}));
    // The text that a recording holds asks for this very content.
    Settings again;
    EXPECT_TRUE(parse_settings(settings.text, {}, again, errors));
    put_text(here + "/p.policy", policy_text(some_policy(4), ""));
    EXPECT_FALSE(parse_settings(settings.text, {}, again, errors));
    EXPECT_NE(format_errors("", errors).find("another content"), std::string::npos);
}

TEST(PoliciesOfAConfig, AreReportedByPlaceWhereTheyAreWrong) {
    const std::string here = policy_folder();
    const std::string world = here + "/world.txtpb";
    put_text(here + "/p.policy", policy_text(some_policy(3), ""));
    const auto of = [&world](const std::string& settings) {
        put_text(world, world_with_policy(settings));
        return mistakes_in_world(world);
    };
    EXPECT_NE(of("file: \"none.policy\"").find("none.policy: cannot be opened"), std::string::npos);
    EXPECT_NE(of("").find("needs a file"), std::string::npos);
    EXPECT_NE(of("file: \"p.policy\" max_speed: 2").find("out of range"), std::string::npos);
    std::string text = policy_text(some_policy(3), "");
    put_text(here + "/damaged.policy", text.replace(text.find("hunger"), 6, "thirst"));
    EXPECT_NE(of("file: \"damaged.policy\"").find("changed or damaged"), std::string::npos);
    learning::Policy thirsty = some_policy(3);
    thirsty.inputs[1].variable = "thirst";
    put_text(here + "/thirsty.policy", policy_text(thirsty, ""));
    const std::string lacking = of("file: \"thirsty.policy\"");
    EXPECT_NE(lacking.find("'thirst', which agents of brain 'wander' do not have"),
              std::string::npos)
        << lacking;
    // With line and column of the block.
    EXPECT_NE(lacking.find("world:"), std::string::npos);
    EXPECT_NE(lacking.find("policy[0]"), std::string::npos);
    std::string both = world_with_policy("file: \"p.policy\"");
    both.replace(both.find("policy: \"learned\""), 17, "policy: \"other\" tree: \"x\"");
    put_text(world, both);
    const std::string found = mistakes_in_world(world);
    EXPECT_NE(found.find("takes one of"), std::string::npos) << found;
    EXPECT_NE(found.find("no policy named 'other'"), std::string::npos) << found;
}

std::string training_mistakes(const std::string& text) {
    TrainingPlan plan;
    std::vector<ConfigError> errors;
    parse_training(text, "/tmp/t.txtpb", plan, errors);
    return format_errors("t", errors);
}

TEST(TrainingFile, ReportsEveryMistakeWithItsPlace) {
    EXPECT_EQ(training_mistakes("task: ARENA hidden { nodes: 8 }"), "");
    const std::string all = training_mistakes(
        "taskk: ARENA\n"
        "method: GRADIENT\n"
        "rounds: 0\n"
        "genetic { elite: 99 }\n");
    EXPECT_NE(all.find("t:1:1: taskk: unknown setting in Training; did you mean 'task'?"),
              std::string::npos)
        << all;
    EXPECT_NE(all.find("t:2:1: method: method GRADIENT needs samples"), std::string::npos) << all;
    EXPECT_NE(all.find("t:3:1: rounds: 0 is out of range"), std::string::npos) << all;
    EXPECT_NE(all.find("t:4:11: genetic.elite: is 99"), std::string::npos) << all;
    EXPECT_NE(training_mistakes("method: NEAT hidden { }").find("grows its own"),
              std::string::npos);
    EXPECT_NE(training_mistakes("task: IMITATION method: GRADIENT").find("recording"),
              std::string::npos);
    EXPECT_NE(training_mistakes("task: IMITATION imitation { recording: \"x\" input { } }")
                  .find("learned by method GRADIENT"),
              std::string::npos);
    EXPECT_NE(training_mistakes("task: IMITATION method: GRADIENT target_score: 1 imitation { "
                                "recording: \"x\" input { variable: \"hunger\" } }")
                  .find("players have no variables"),
              std::string::npos);
    EXPECT_NE(training_mistakes("seed: 1\nrounds: -").find("t:2:1: rounds:"), std::string::npos)
        << training_mistakes("seed: 1\nrounds: -");
    EXPECT_NE(training_mistakes("seed: 1\n}").find("t:2:1: syntax"), std::string::npos);
}

TEST(TrainingFile, IsTheSameTrainingWithMoreRoundsAndAnotherWithAnotherSeed) {
    const auto digest = [](const std::string& text) {
        TrainingPlan plan;
        std::vector<ConfigError> errors;
        EXPECT_TRUE(parse_training(text, "/tmp/t.txtpb", plan, errors));
        return plan.digest;
    };
    EXPECT_EQ(digest("rounds: 5"), digest("rounds: 50 target_score: 3 policy_file: \"x\""));
    EXPECT_NE(digest("rounds: 5"), digest("rounds: 5 seed: 2"));
    EXPECT_NE(digest("rounds: 5"), digest("rounds: 5 hidden { nodes: 3 }"));
}

TEST(Checkpoint, OfEveryKindOfDamageIsRefusedOrTheSame) {
    const std::string file = policy_folder() + "/c";
    proto::TrainingCheckpoint checkpoint;
    checkpoint.set_round(7);
    checkpoint.add_individual()->add_gene(0.5F);
    ASSERT_TRUE(write_checkpoint(file, checkpoint).ok());
    ASSERT_TRUE(read_checkpoint(file).ok());
    EXPECT_EQ(read_checkpoint(file)->round(), 7u);
    std::ifstream in(file, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    const std::string bytes = text.str();
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        std::string other = bytes;
        other[i] = static_cast<char>(other[i] ^ 1);
        put_text(file, other);
        EXPECT_FALSE(read_checkpoint(file).ok()) << i;
        put_text(file, bytes.substr(0, i));
        EXPECT_FALSE(read_checkpoint(file).ok()) << i;
    }
}

TEST(Checkpoint, OfAnotherTaskOrWithUnsoundGenomesIsRefused) {
    proto::Training config;
    config.set_method(proto::Training::NEAT);
    config.mutable_neat()->set_population(4);
    const learning::BreedingSettings settings = breeding_of(config, 2, 1);
    learning::Neat neat(std::get<learning::NeatSettings>(settings), 2, 1, 3);
    learning::Evolution::EvolutionState state;
    state.population = neat.state();
    state.best = network_of(neat.genomes()[0]);
    proto::TrainingCheckpoint good;
    fill(state, good);
    EXPECT_TRUE(evolution_state(good, settings, 2, 1).ok());
    EXPECT_FALSE(evolution_state(good, settings, 3, 1).ok());
    const auto broken = [&](const auto& change) {
        proto::TrainingCheckpoint message = good;
        change(message);
        return !evolution_state(message, settings, 2, 1).ok();
    };
    using Message = proto::TrainingCheckpoint;
    EXPECT_TRUE(broken([](Message& m) { m.mutable_genome()->RemoveLast(); }));
    EXPECT_TRUE(broken([](Message& m) { m.clear_species(); }));
    EXPECT_TRUE(broken([](Message& m) { m.mutable_species(0)->set_member(0, 9); }));
    EXPECT_TRUE(broken([](Message& m) { m.mutable_genome(1)->mutable_link(0)->set_to(0); }));
    EXPECT_TRUE(broken([](Message& m) { m.mutable_genome(1)->mutable_link(0)->set_from(77); }));
    EXPECT_TRUE(
        broken([](Message& m) { m.mutable_genome(1)->mutable_link(1)->set_innovation(0); }));
    EXPECT_TRUE(broken([](Message& m) {
        auto& link = *m.mutable_genome(1)->mutable_link(0);  // an output that reads itself
        link.set_from(link.to());
    }));
}

}  // namespace
}  // namespace zoned::config
