// cluster, arrival and portal of a config: what they become, and which mistakes are found.
#include "tests/unit/config/config_helpers.h"

namespace zoned::config::test {
namespace {

/// Empty: the config is good. kValid is a world of one zone around the origin.
std::string complaint_about(const std::string& more) {
    const Outcome outcome = parse(std::string(kValid) + more);
    return outcome.ok ? "" : format_errors("test", outcome.errors);
}

constexpr const char* kBox = "min_x_m: 1 min_z_m: 1 max_x_m: 3 max_z_m: 4";

std::string portal(const std::string& more) {
    return "cluster { name: \"castle\" } portal { " + more + " }\n";
}

void wants(const std::string& config, const std::string& text) {
    const std::string complaint = complaint_about(config);
    EXPECT_NE(complaint.find(text), std::string::npos) << config << ": " << complaint;
}

TEST(ClusterConfig, TakesNamesLeaseAndPlaces) {
    const Outcome parsed = parse(std::string(kValid) +
                                 "cluster { name: \"castle-1\" realm: \"r_2\" lease_s: 20 "
                                 "replicas: 3 }\n"
                                 "arrival { name: \"gate\" x_m: 2 y_m: 3 z_m: 4 }\n");
    ASSERT_TRUE(parsed.ok) << format_errors("test", parsed.errors);
    EXPECT_EQ(parsed.settings.server.cluster, (ClusterSettings{"castle-1", "r_2", 20.0, 3}));
    ASSERT_EQ(parsed.settings.server.arrivals.size(), 1U);
    EXPECT_EQ(parsed.settings.server.arrivals[0], (ArrivalSettings{"gate", {2.0, 3.0, 4.0}}));
}

TEST(ClusterConfig, NamesArePartsOfKeysAndSubjects) {
    wants("cluster { }", "cluster: name is missing");
    wants("cluster { name: \"a.b\" }", "must consist of letters, digits, - and _");
    wants("cluster { name: \"a b\" }", "must consist of letters, digits, - and _");
    wants("cluster { name: \"a\" realm: \"*\" }", "cluster.realm");
    wants("cluster { name: \"a\" lease_s: 0.5 }", "lease_s");
}

TEST(ClusterConfig, APortalLeadsSomewhereElse) {
    wants("portal { name: \"p\" " + std::string(kBox) + " to_world: \"m\" }",
          "no meaning without cluster.name");
    wants(portal("name: \"p\" " + std::string(kBox)), "to_world is missing");
    wants(portal("name: \"p\" " + std::string(kBox) + " to_world: \"castle\""),
          "is this world itself");
    wants(portal("name: \"p\" " + std::string(kBox) + " to_world: \"a/b\""),
          "must consist of letters");
    wants(portal("name: \"p\" to_world: \"m\" min_x_m: 1"), "min_z_m is missing");
    wants(portal("name: \"p\" to_world: \"m\" min_x_m: 5 min_z_m: 1 max_x_m: 3 max_z_m: 4"),
          "min_x_m must be less than max_x_m");
    wants(portal("name: \"p\" " + std::string(kBox) + " to_world: \"m\""),
          "only clients with a ticket can travel");
    wants(portal("name: \"p\" " + std::string(kBox) + " to_world: \"m\"") +
              "portal { name: \"p\" " + kBox + " to_world: \"m\" }",
          "is given twice");
}

TEST(ClusterConfig, NobodyArrivesWhereItWouldLeaveAtOnceOrOutsideTheWorld) {
    wants("cluster { name: \"castle\" } arrival { name: \"a\" x_m: 40000 }", "lies in no zone");
    wants(portal("name: \"p\" " + std::string(kBox) + " to_world: \"m\"") +
              "arrival { name: \"a\" x_m: 2 z_m: 2 }",
          "would leave at once");
    const std::string waits =
        complaint_about(portal("name: \"p\" " + std::string(kBox) + " to_world: \"m\" wait_s: 1") +
                        "arrival { name: \"a\" x_m: 2 z_m: 2 }");
    EXPECT_EQ(waits.find("would leave at once"), std::string::npos) << waits;
}

TEST(ClusterConfig, AWorldThatGoesOnFromBeforeACrashMayBeInACluster) {
    EXPECT_EQ(complaint_about("cluster { name: \"castle\" } recovery { on: true }"), "");
}

}  // namespace
}  // namespace zoned::config::test
