#include "server/admin/json_body.h"

#include "proto/admin.pb.h"

#include <gtest/gtest.h>

namespace zoned::admin {
namespace {

TEST(JsonBody, ReadsWhatItWrote) {
    proto::admin::KickRequest kick;
    kick.set_client(7);
    kick.set_reason("quote \" and \xC3\xA4");
    proto::admin::KickRequest read;
    ASSERT_TRUE(from_json(to_json(kick), read).ok());
    EXPECT_EQ(read.SerializeAsString(), kick.SerializeAsString());
}

TEST(JsonBody, TakesNothingForAnEmptyObject) {
    proto::admin::DrainRequest drain;
    EXPECT_TRUE(from_json("", drain).ok());
    EXPECT_TRUE(from_json(" \n", drain).ok());
}

TEST(JsonBody, RefusesWhatIsNoSuchMessage) {
    for (const std::string& text : {std::string("{"),
                                    std::string("[]"),
                                    std::string("{\"client\": -1}"),
                                    std::string("{\"client\": \"x\"}"),
                                    std::string("{\"nobody\": 1}"),
                                    std::string("{} {}"),
                                    std::string("{\"reason\": \"\xFF\"}"),
                                    std::string(65536, '['),
                                    std::string("\0", 1)}) {
        proto::admin::KickRequest kick;
        EXPECT_FALSE(from_json(text, kick).ok()) << text.substr(0, 40);
    }
}

}  // namespace
}  // namespace zoned::admin
