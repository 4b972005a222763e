// Recovery: a run that ended at any moment goes on bit for bit.
#include "server/app/recovery/recovery.h"

#include "server/app/recovery/world_life.h"
#include "server/config/expand/load_settings.h"
#include "server/recording/recording_reader.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace zoned::app {
namespace {

namespace fs = std::filesystem;

class Recovered : public testing::Test {
  protected:
    Recovered() {
        folder = testing::TempDir() + "zoned_recovery_" +
                 testing::UnitTest::GetInstance()->current_test_info()->name();
        fs::remove_all(folder);
        load({});
    }

    ~Recovered() override { fs::remove_all(folder); }

    void load(const std::vector<std::string>& more) {
        std::vector<std::string> sets{"session.state_folder=\"" + folder + "\"",
                                      "recovery.on=true",
                                      "recovery.durability=DURABLE_PROCESS",
                                      "recovery.snapshot_every_s=1",
                                      "recording.ring_s=0"};
        sets.insert(sets.end(), more.begin(), more.end());
        std::vector<config::ConfigError> errors;
        settings = config::Settings();
        ASSERT_TRUE(config::load_settings(
            ZONED_SOURCE_DIR "/config/minimal.txtpb", sets, settings, errors));
    }

    [[nodiscard]] std::string journal() const { return folder + "/journal"; }

    /// The inputs of a tick, the same each time.
    static std::vector<mailbox::InboxItem> inputs(Tick tick) {
        core::Rng rng(static_cast<std::uint64_t>(tick));
        std::vector<mailbox::InboxItem> items;
        if (tick == 3) {
            items.emplace_back(mailbox::SessionBegun{
                ClientId(1), mailbox::Bytes(32, 9), "acc", "ann", "red", 3, false});
            items.emplace_back(
                mailbox::Join{ClientId(1), "ann", "red", 3, {0.0, 0.0, 0.0}, "", false});
        }
        if (tick > 3) {
            motion::InputCommand command;
            command.tick = tick;
            command.move_x = static_cast<std::int8_t>(rng.range(-127.0F, 127.0F));
            command.move_z = static_cast<std::int8_t>(rng.range(-127.0F, 127.0F));
            command.buttons = static_cast<std::uint16_t>(rng.below(4));
            items.emplace_back(mailbox::Input{ClientId(1), {command}});
        }
        if (tick % 50 == 7) {
            items.emplace_back(mailbox::SessionProgress{ClientId(1), std::uint64_t(tick), 0});
        }
        return items;
    }

    /// A server without sockets.
    struct Run {
        explicit Run(const config::Settings& of, const std::string& life = "")
            : world(of, 1),
              recovery(std::make_unique<Recovery>(of)),
              found(recovery->begin(world, life)) {
            recording::RecorderSettings s;
            s.journal_folder = recovery->folder();
            s.journal_for_power = false;
            s.rate_hz = of.tick_rate_hz;
            s.header = recording::RecordingHeader::of_this_build();
            s.header.config_digest = of.digest;
            recorder = std::make_unique<recording::Recorder>(
                s, [this](const std::string& text) { told += text; });
            EXPECT_TRUE(recorder->open().ok());
        }

        void go(Tick to) {
            std::vector<mailbox::OutboxItem> out;
            std::vector<std::uint64_t> hashes;
            while (world.now() < to) {
                const auto items = recorder->lend();
                *items = inputs(world.now() + 1);
                recorder->begin_tick(world.now() + 1, items);
                out.clear();
                world.tick(*items, out);
                world.hash_zones(hashes);
                recorder->end_tick(world.now(), hashes);
                recovery->after_tick(world, *items, out, *recorder);
            }
        }

        static constexpr Tick kPatience_ticks = 140;  ///< most that rest() goes on

        /// Until the copies that write snapshots are done.
        void rest(std::uint64_t snapshots) {
            for (Tick i = 0; i < kPatience_ticks && recovery->figures().taken < snapshots; ++i) {
                ::usleep(60000);
                go(world.now() + 1);
            }
            EXPECT_GE(recovery->figures().taken, snapshots);
        }

        World world;
        std::unique_ptr<Recovery> recovery;
        RecoveredRun found;
        std::string told;
        std::unique_ptr<recording::Recorder> recorder;
    };

    /// An uninterrupted run.
    std::uint64_t hash_at(Tick tick) {
        World world(settings, 1);
        std::vector<mailbox::OutboxItem> out;
        while (world.now() < tick) {
            world.tick(inputs(world.now() + 1), out);
            out.clear();
        }
        return world.state_hash();
    }

    std::string newest_piece() const {
        std::string newest;
        for (const auto& entry : fs::directory_iterator(journal())) {
            if (entry.path().extension() == ".zrec") {
                newest = std::max(newest, entry.path().string());
            }
        }
        return newest;
    }

    /// Folders with what is not gone on from.
    [[nodiscard]] std::ptrdiff_t set_aside() const {
        const fs::directory_iterator entries(folder);
        return std::count_if(fs::begin(entries), fs::end(entries), [](const auto& entry) {
            return entry.path().filename().string().starts_with("journal-");
        });
    }

    std::string folder;
    config::Settings settings;
};

TEST_F(Recovered, GoesOnAtTheTickAtWhichItEndedHoweverOften) {
    Tick at = 0;
    core::Rng rng(5);
    for (int deaths = 0; deaths < 8; ++deaths) {
        Run run(settings);
        EXPECT_EQ(run.found.tick, at);
        EXPECT_EQ(run.found.trouble, "");
        EXPECT_EQ(run.world.now(), at);
        EXPECT_EQ(run.world.state_hash(), hash_at(at));
        EXPECT_EQ(run.recovery->ledger().sessions().size(), at >= 3 ? 1U : 0U);
        at += 1 + static_cast<Tick>(rng.below(90));
        run.go(at);
        EXPECT_EQ(run.told, "");
    }
    Run run(settings);
    EXPECT_EQ(run.recovery->ledger().commands_of(ClientId(1)),
              std::uint64_t((at - 7) / 50 * 50 + 7));
    run.go(at + 100);
    EXPECT_EQ(run.world.state_hash(), hash_at(at + 100));
}

TEST_F(Recovered, ForgetsWhatOlderSnapshotsNeeded) {
    // So seldom that no fourth one begins while the third is waited for, and so often that the
    // recorder's queue, of ten seconds, takes all that is played at once.
    load({"recovery.snapshot_every_s=5"});
    const Tick apart = 5 * 30;
    ASSERT_GT(apart, Run::kPatience_ticks + 3);
    Run run(settings);
    run.go(apart + 1);
    run.rest(1);
    run.go(run.world.now() + apart);
    run.rest(2);
    run.go(run.world.now() + apart);
    run.rest(3);
    EXPECT_EQ(snapshots_in(journal()).size(), 2U) << "the newest and the one before it";
    EXPECT_EQ(run.recovery->figures().failed, 0U);
    EXPECT_FALSE(fs::exists(journal() + "/attempts"));
    run.go(run.world.now() + 3);
    run.recorder.reset();  // all is written
    std::size_t pieces = 0;
    for (const auto& entry : fs::directory_iterator(journal())) {
        pieces += entry.path().extension() == ".zrec" ? 1 : 0;
    }
    EXPECT_LE(pieces, 3U);
    recording::RecordingReader reader;
    recording::TickRecord record;
    ASSERT_TRUE(reader.open(journal()).ok());
    ASSERT_TRUE(reader.next(record).ok());
    EXPECT_EQ(record.tick, snapshots_in(journal()).back().tick + 1);
}

TEST_F(Recovered, ComesBackFromEachPlaceWhereAWriteMayHaveStopped) {
    {
        Run run(settings);
        run.go(20);
    }
    const std::string piece = newest_piece();
    std::string bytes;
    {
        std::ifstream in(piece, std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(in), {});
    }
    fs::copy(journal(), folder + "/kept");
    core::Rng rng(2);
    Tick before = 20;
    for (std::size_t size = bytes.size(); size > 400; size -= 1 + rng.below(120)) {
        fs::remove_all(journal());
        fs::copy(folder + "/kept", journal());
        fs::resize_file(piece, size);
        {
            Run run(settings);
            EXPECT_LE(run.found.tick, before);
            before = run.found.tick;
            EXPECT_EQ(run.world.state_hash(), hash_at(run.found.tick)) << size << " bytes";
            run.go(before + 3);
        }
        // The half frame of the run before is in nobody's way.
        const Run again(settings);
        EXPECT_EQ(again.found.tick, before + 3);
    }
    EXPECT_LT(before, 18);
}

TEST_F(Recovered, TakesTheSnapshotBeforeADamagedOne) {
    Tick at = 0;
    {
        Run run(settings);
        run.go(40);
        run.rest(1);
        run.go(run.world.now() + 40);
        run.rest(2);
        at = run.world.now();
    }
    const std::vector<SnapshotFile> files = snapshots_in(journal());
    ASSERT_EQ(files.size(), 2U);
    EXPECT_GT(files[0].tick, files[1].tick) << "the newest first";
    const auto spoil = [](const std::string& path) {
        std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(5000);
        file.put('\x5a');
        file.seekp(5001);
        file.put('\x5b');
    };
    spoil(files[0].path);
    {
        const Run run(settings);
        EXPECT_EQ(run.found.snapshot, files[1].tick);
        EXPECT_EQ(run.found.tick, at);
        EXPECT_NE(run.found.trouble.find("checksum"), std::string::npos) << run.found.trouble;
        EXPECT_EQ(run.world.state_hash(), hash_at(at));
        // The client joined long before that snapshot.
        const std::vector<session::KeptSession> kept = run.recovery->ledger().sessions();
        ASSERT_EQ(kept.size(), 1U);
        EXPECT_TRUE(kept[0].joined.has_value());
        EXPECT_GT(kept[0].events.newest(), 0U) << "it was told where it is";
    }
    spoil(snapshots_in(journal()).at(0).path);
    try {
        const Run run(settings);
        FAIL() << "it went on from nothing";
    } catch (const std::runtime_error& error) {
        EXPECT_NE(std::string(error.what()).find("move the folder away"), std::string::npos)
            << error.what();
    }
}

TEST_F(Recovered, SaysWhatToDoWhereTheConfigIsAnother) {
    {
        Run run(settings);
        run.go(10);
    }
    load({"session.grace_s=31"});
    for (int tries = 0; tries < 10; ++tries) {
        try {
            const Run run(settings);
            FAIL() << "it went on with another config";
        } catch (const std::runtime_error& error) {
            const std::string text = error.what();
            EXPECT_NE(text.find("another config"), std::string::npos) << text;
            EXPECT_NE(text.find("move '"), std::string::npos) << text;
        }
    }
    load({});
    EXPECT_EQ(Run(settings).found.tick, 10) << "a refused start is no death";
}

TEST_F(Recovered, LeavesOutTheTickThatKillsItAndAtLastBeginsAnew) {
    {
        Run run(settings);
        run.go(10);
        // The server died within tick 11: its inputs are there, its hashes are not.
        const auto items = run.recorder->lend();
        *items = inputs(11);
        run.recorder->begin_tick(11, items);
    }
    // Nobody hears of a start that dies while it brings the world back.
    fs::copy(journal(), folder + "/kept");
    const auto start = [&](unsigned attempts) {
        fs::remove_all(journal());
        fs::copy(folder + "/kept", journal());
        std::ofstream(journal() + "/attempts") << attempts;
        const Run run(settings);
        return run.found.tick;
    };
    EXPECT_EQ(start(0), 11);
    EXPECT_EQ(start(1), 11);
    EXPECT_EQ(start(2), 10) << "the third start";
    EXPECT_EQ(start(5), 0) << "the sixth";
    EXPECT_EQ(set_aside(), 1) << "what was there is kept";
}

TEST_F(Recovered, AStopInGoodOrderBeginsAnewUnlessAskedNotTo) {
    {
        Run run(settings);
        run.go(50);
        run.recorder.reset();
        EXPECT_EQ(run.recovery->end(run.world), "");
    }
    EXPECT_EQ(Run(settings).found.tick, 0);
    fs::remove_all(folder);
    load({"recovery.over_restarts=true"});
    {
        Run run(settings);
        run.go(50);
        run.recorder.reset();
        EXPECT_EQ(run.recovery->end(run.world), "");
    }
    const Run run(settings);
    EXPECT_EQ(run.found.tick, 50);
    EXPECT_EQ(run.world.state_hash(), hash_at(50));
}

TEST_F(Recovered, GoesOnInItsOwnLifeAlone) {
    const std::string first(kLifeBytes, '\x01');
    const std::string second(kLifeBytes, '\x02');
    EXPECT_EQ(kept_life(settings), "") << "there is no state";
    Run(settings, first).go(10);
    EXPECT_EQ(kept_life(settings), first);
    {
        Run run(settings, first);
        EXPECT_EQ(run.found.tick, 10);
        EXPECT_EQ(run.found.recoveries, 1U);
        run.go(15);
    }
    {
        // Another server has had the world.
        Run run(settings, second);
        EXPECT_EQ(run.found.tick, 0);
        EXPECT_EQ(run.found.sessions, 0U);
        EXPECT_EQ(set_aside(), 1);
        EXPECT_EQ(kept_life(settings), second);
        run.go(5);
    }
    {
        Run run(settings, second);
        EXPECT_EQ(run.found.tick, 5) << "what it kept since is the world's";
        EXPECT_EQ(run.found.recoveries, 1U) << "since it began anew";
    }
    EXPECT_EQ(Run(settings).found.tick, 5) << "without a cluster nobody else can have had it";
    EXPECT_EQ(set_aside(), 1);
}

TEST_F(Recovered, GoesOnFromNoStateWhoseLifeCannotBeRead) {
    const std::string life(kLifeBytes, '\xfe');
    Run(settings, life).go(10);
    for (const char* damaged : {"", "fe\n", "no hexadecimal digits at all here\n"}) {
        std::ofstream(journal() + "/life", std::ios::trunc) << damaged;
        EXPECT_EQ(kept_life(settings), "") << damaged;
    }
    EXPECT_EQ(Run(settings, life).found.tick, 0);
    EXPECT_EQ(set_aside(), 1);
    fs::remove(journal() + "/life");
    fs::create_directories(journal() + "/life.part");
    EXPECT_THROW(note_life(settings, life), std::runtime_error);
}

TEST_F(Recovered, IsForOneServerAtATime) {
    const Run run(settings);
    EXPECT_THROW(Recovery{settings}, std::runtime_error);
}

}  // namespace
}  // namespace zoned::app
