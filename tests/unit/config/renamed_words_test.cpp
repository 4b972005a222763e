// Words that earlier configs used: each leads to a word of the schema, which the error names.
// uses it.
#include "server/config/text/renamed_words.h"

#include "tests/unit/config/config_helpers.h"
#include "proto/config/config.pb.h"

#include <google/protobuf/descriptor.h>

namespace zoned::config::test {
namespace {

using google::protobuf::DescriptorPool;

TEST(RenamedWords, LeadToWordsOfTheSchemaFromWordsThatItNoLongerHas) {
    ASSERT_NE(proto::config::Config::descriptor(), nullptr);
    const DescriptorPool& pool = *DescriptorPool::generated_pool();
    for (const RenamedWord& word : renamed_words()) {
        SCOPED_TRACE(std::string(word.scope) + "." + std::string(word.before));
        const std::string before(word.before);
        const std::string now(word.now);
        if (const auto* message = pool.FindMessageTypeByName(std::string(word.scope))) {
            EXPECT_EQ(message->FindFieldByName(before), nullptr);
            EXPECT_NE(message->FindFieldByName(now), nullptr);
        } else if (const auto* choice = pool.FindEnumTypeByName(std::string(word.scope))) {
            EXPECT_EQ(choice->FindValueByName(before), nullptr);
            EXPECT_NE(choice->FindValueByName(now), nullptr);
        } else {
            ADD_FAILURE() << "the schema has no such message or enum";
        }
    }
}

TEST(RenamedWords, AreToldWithTheirPlaceToWhoUsesTheOldOne) {
    expect_single(kValid + "ai { ways { cell_m: 2 } }\n", "ways", "it is called 'pathfinding' now");
    expect_single(kValid + "slow { }\n", "slow", "it is called 'environment' now");
    const Outcome map = parse(kValid + "ai { pathfinding {\n  map: MESH } }\n");
    ASSERT_EQ(map.errors.size(), 1U) << format_errors("test", map.errors);
    EXPECT_NE(map.errors[0].text.find("it is called 'NAVMESH' now"), std::string::npos);
    EXPECT_EQ(map.errors[0].column, 3);
}

TEST(RenamedWords, AreToldOfSettingsOnTheCommandLineToo) {
    const Outcome out = parse(kValid, {"ai.ways.cell_m=2"});
    ASSERT_EQ(out.errors.size(), 1U);
    EXPECT_NE(out.errors[0].text.find("it is called 'pathfinding' now"), std::string::npos)
        << out.errors[0].text;
}

}  // namespace
}  // namespace zoned::config::test
