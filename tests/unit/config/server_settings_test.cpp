// Settings of the server as plain structs: without a config they are what the schema's defaults
// are.
#include "server/config/expand/expand_server.h"
#include "tests/unit/config/config_helpers.h"
#include "proto/config/config.pb.h"

namespace zoned::config::test {
namespace {

TEST(ServerSettings, HaveTheDefaultsOfTheSchema) {
    const ServerSettings from_schema = expand_server(proto::config::Config());
    const ServerSettings plain;
    EXPECT_EQ(from_schema.network, plain.network);
    EXPECT_EQ(from_schema.session, plain.session);
    EXPECT_EQ(from_schema.agones, plain.agones);
    EXPECT_EQ(from_schema.run, plain.run);
    EXPECT_EQ(from_schema.compute, plain.compute);
    EXPECT_EQ(from_schema.recording_file, plain.recording_file);
    EXPECT_EQ(from_schema.ring_s, plain.ring_s);
    EXPECT_EQ(from_schema.store, plain.store);
    EXPECT_EQ(from_schema.cluster, plain.cluster);
    EXPECT_EQ(from_schema.arrivals, plain.arrivals);
    EXPECT_EQ(from_schema.portals, plain.portals);
    EXPECT_EQ(from_schema.testing.travel.die_at, plain.testing.travel.die_at);
    EXPECT_EQ(from_schema.testing.travel.die_after, plain.testing.travel.die_after);
    EXPECT_EQ(from_schema.testing.faults, plain.testing.faults);
    EXPECT_FALSE(from_schema.testing.stall || from_schema.testing.wrong_limit);
}

TEST(ServerSettings, ClientsHearWithinHalfASecondAtAnyTickRate) {
    for (const double rate_hz : {5.0, 7.5, 20.0, 23.9, 24.0, 30.0, 240.0}) {
        const Outcome parsed = parse(kValid, {"world.tick_rate_hz=" + std::to_string(rate_hz)});
        ASSERT_TRUE(parsed.ok) << format_errors("test", parsed.errors);
        const std::uint32_t ticks = parsed.settings.replication.silence_ticks;
        EXPECT_LE(ticks / rate_hz, 0.5);
        EXPECT_TRUE(ticks == 12 || (ticks + 1) / rate_hz > 0.5) << "as many as fit";
    }
}

TEST(ServerSettings, SettingsThatAreMadeWithoutAConfigHaveTheDefaultsOfTheSchema) {
    const Outcome parsed = parse(kValid);
    ASSERT_TRUE(parsed.ok) << format_errors("test", parsed.errors);
    const Settings plain;
    EXPECT_EQ(parsed.settings.audit.enabled, plain.audit.enabled);
    EXPECT_EQ(parsed.settings.audit.period_ticks, plain.audit.period_ticks);
    EXPECT_EQ(parsed.settings.rewind.most_ticks, plain.rewind.most_ticks);
    EXPECT_EQ(parsed.settings.rewind.slack_m, plain.rewind.slack_m);
    EXPECT_EQ(parsed.settings.visibility_filter.checks_per_tick,
              plain.visibility_filter.checks_per_tick);
    EXPECT_EQ(parsed.settings.visibility_filter.stale_ticks, plain.visibility_filter.stale_ticks);
    EXPECT_EQ(parsed.settings.visibility_filter.grace_ticks, plain.visibility_filter.grace_ticks);
}

TEST(ServerSettings, TakeWhatTheConfigSays) {
    const Outcome parsed =
        parse(with("dev_mode_loopback: true",
                   "dev_mode_loopback: true dev_rights: PLAY dev_rights: ADMIN") +
              "network { udp_port: 4000 max_clients: 7 }\n"
              "run { log_level: LEVEL_WARNING }\n"
              "topic { name: \"news/*\" history_events: 3 }\n"
              "testing { stall_zone { zone: \"east\" at_tick: 5 } "
              "leak_topic { probability: 1 } }\n");
    ASSERT_TRUE(parsed.ok) << format_errors("test", parsed.errors);
    const ServerSettings& server = parsed.settings.server;
    EXPECT_EQ(server.network.udp_port, 4000);
    EXPECT_EQ(server.network.max_clients, 7U);
    EXPECT_EQ(server.session.dev_rights, 9U);
    EXPECT_EQ(server.run.log_level, LogLevel::kWarning);
    ASSERT_EQ(server.topics.size(), 1U);
    EXPECT_EQ(server.topics[0].name, "news/*");
    EXPECT_EQ(server.topics[0].events, 3U);
    ASSERT_TRUE(server.testing.stall);
    EXPECT_EQ(server.testing.stall->zone, "east");
    EXPECT_EQ(server.testing.stall->at_tick, 5);
    EXPECT_EQ(server.testing.leak_topic.share, 1.0);
}

TEST(ServerSettings, TheStoreLiesInTheStateFolderUnlessItIsNamed) {
    const Outcome usual = parse(
        with("dev_mode_loopback: true", "dev_mode_loopback: true state_folder: \"/var/lib/z\""));
    ASSERT_TRUE(usual.ok) << format_errors("test", usual.errors);
    EXPECT_EQ(usual.settings.server.store.file, "/var/lib/z/store.db");
    EXPECT_EQ(usual.settings.server.store.durability, StoreDurability::kPower);
    const Outcome named =
        parse(std::string(kValid) +
              "store { file: \"/srv/s.db\" durability: DURABLE_PROCESS max_waiting_mb: 5 }\n");
    ASSERT_TRUE(named.ok) << format_errors("test", named.errors);
    EXPECT_EQ(named.settings.server.store,
              (StoreSettings{StoreKind::kSqlite, "/srv/s.db", StoreDurability::kProcess, 5, ""}));
}

TEST(ServerSettings, AStoreThatIsOffHasNoFile) {
    const Outcome off = parse(std::string(kValid) + "store { kind: STORE_NONE }\n");
    ASSERT_TRUE(off.ok) << format_errors("test", off.errors);
    EXPECT_EQ(off.settings.server.store.kind, StoreKind::kNone);
    const Outcome odd = parse(std::string(kValid) + "store { kind: STORE_NONE file: \"s.db\" }\n");
    ASSERT_FALSE(odd.ok);
    EXPECT_NE(format_errors("test", odd.errors).find("no meaning while store.kind is STORE_NONE"),
              std::string::npos)
        << format_errors("test", odd.errors);
}

std::string complaint_about_store(const std::string& store) {
    const Outcome outcome = parse(std::string(kValid) + "store { " + store + " }\n");
    return outcome.ok ? "" : format_errors("test", outcome.errors);
}

TEST(ServerSettings, AStoreInPostgresqlHasAUrl) {
    const std::string url = "postgresql://zoned@[::1]:5432,b:5433/game?passfile=/etc/zoned/pgpass";
    const Outcome good =
        parse(std::string(kValid) + "store { kind: STORE_POSTGRESQL url: \"" + url + "\" }\n");
    ASSERT_TRUE(good.ok) << format_errors("test", good.errors);
    EXPECT_EQ(good.settings.server.store.kind, StoreKind::kPostgresql);
    EXPECT_EQ(good.settings.server.store.url, url);
    for (const char* also : {"postgres://h/d",
                             "postgresql:///d?host=/run/postgresql",
                             "postgresql://u@h",
                             "postgresql://h/d?user=u&sslmode=verify-full"}) {
        EXPECT_EQ(
            complaint_about_store("kind: STORE_POSTGRESQL url: \"" + std::string(also) + "\""), "")
            << also;
    }
    const auto wants = [](const std::string& store, const std::string& text) {
        const std::string complaint = complaint_about_store(store);
        EXPECT_NE(complaint.find(text), std::string::npos) << store << ": " << complaint;
    };
    wants("kind: STORE_POSTGRESQL", "store.url: is missing");
    wants("kind: STORE_POSTGRESQL url: \"host=h\"", "is no URL of a PostgreSQL database");
    wants("kind: STORE_POSTGRESQL url: \"mysql://h/d\"", "is no URL of a PostgreSQL database");
    wants("kind: STORE_POSTGRESQL url: \"postgresql://h/a b\"", "%20");
    wants("kind: STORE_POSTGRESQL url: \"postgresql://h/d\" file: \"s.db\"",
          "no meaning while store.kind is STORE_POSTGRESQL");
    wants("kind: STORE_POSTGRESQL url: \"postgresql://h/d\" durability: DURABLE_PROCESS",
          "no meaning while store.kind is STORE_POSTGRESQL");
    wants("url: \"postgresql://h/d\"", "no meaning while store.kind is STORE_SQLITE");
}

TEST(ServerSettings, APasswordInTheUrlOfTheStoreIsRefusedAndNotRepeated) {
    for (const char* url : {"postgresql://u:sEcret@h/d",
                            "postgresql://u:sEc/ret@h/d",
                            "postgresql://:sEcret@h/d",
                            "postgresql://a?u:sEcret@h/d",
                            "postgresql://u@x:sEcret@h/d",
                            "postgresql://h/d?password=sEcret",
                            "postgresql://h/d?user=u&PassWord=sEcret",
                            "postgresql://h/d?sslpassword=sEcret",
                            "postgresql://h?p%61ssword=sEcret"}) {
        const std::string complaint =
            complaint_about_store("kind: STORE_POSTGRESQL url: \"" + std::string(url) + "\"");
        EXPECT_NE(complaint.find("PGPASSWORD"), std::string::npos) << url << ": " << complaint;
        EXPECT_EQ(complaint.find("sEc"), std::string::npos) << complaint;
    }
}

}  // namespace
}  // namespace zoned::config::test
