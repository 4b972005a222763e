// Journal: what is told to be kept is on disk, and a disk that fails holds nobody up.
#include "server/recording/recorder.h"
#include "server/recording/recording_reader.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <mutex>
#include <thread>

namespace zoned::recording {
namespace {

namespace fs = std::filesystem;

class Journals : public testing::Test {
  protected:
    Journals() {
        folder = testing::TempDir() + "zoned_journal_" +
                 testing::UnitTest::GetInstance()->current_test_info()->name();
        fs::remove_all(folder);
        fs::create_directories(folder);
    }

    ~Journals() override { fs::remove_all(folder); }

    std::unique_ptr<Recorder> open(const std::string& in) {
        RecorderSettings s;
        s.header = RecordingHeader::of_this_build();
        s.header.config_digest = "d";
        s.rate_hz = 10.0;
        s.journal_folder = in;
        s.kept = [this](Tick tick) {
            held = true;
            const std::lock_guard waits(hold);
            held = false;
            EXPECT_GT(tick, kept.load()) << "in their order";
            kept.store(tick);
        };
        auto out = std::make_unique<Recorder>(s, [this](const std::string& text) {
            const std::lock_guard lock(mutex);
            told.push_back(text);
        });
        EXPECT_TRUE(out->open().ok());
        return out;
    }

    void play(Recorder& recorder, Tick first, Tick last, std::size_t bytes = 10) {
        for (Tick tick = first; tick <= last; ++tick) {
            const auto inputs = recorder.lend();
            inputs->push_back(mailbox::Command{
                ClientId(1), 3, mailbox::Bytes(bytes, static_cast<std::uint8_t>(tick)), 0});
            recorder.begin_tick(tick, inputs);
            wait_until_kept(tick);
            recorder.end_tick(tick, {static_cast<std::uint64_t>(tick)});
        }
    }

    /// All that was pushed is with the writer, without the inputs of a tick behind it.
    static void write_now(Recorder& recorder) {
        std::promise<void> answered;
        recorder.stop_file([&](const core::Result<std::string>&) { answered.set_value(); });
        answered.get_future().wait();
    }

    /// The writer waits for `hold`.
    void wait_until_held() {
        for (int i = 0; i < 20000 && !held; ++i) {
            std::this_thread::sleep_for(std::chrono::microseconds(500));
        }
        ASSERT_TRUE(held);
    }

    void wait_until_kept(Tick tick) {
        for (int i = 0; i < 20000 && kept.load() < tick; ++i) {
            std::this_thread::sleep_for(std::chrono::microseconds(500));
        }
        ASSERT_GE(kept.load(), tick);
    }

    /// First and last tick that can be read.
    static std::pair<Tick, Tick> span_of(const std::string& path) {
        RecordingReader reader;
        std::pair<Tick, Tick> span{0, 0};
        EXPECT_TRUE(reader.open(path).ok());
        TickRecord record;
        for (auto more = reader.next(record); more.ok() && *more; more = reader.next(record)) {
            span.first = span.first == 0 ? record.tick : span.first;
            span.second = record.tick;
        }
        return span;
    }

    [[nodiscard]] std::size_t pieces() const {
        std::size_t count = 0;
        for (const auto& entry : fs::directory_iterator(folder)) {
            count += entry.path().extension() == ".zrec" ? 1 : 0;
        }
        return count;
    }

    std::string folder;
    std::atomic<Tick> kept{0};
    std::mutex hold;  ///< the writer waits for it before it tells that a tick is kept
    std::atomic<bool> held{false};
    std::mutex mutex;
    std::vector<std::string> told;
};

TEST_F(Journals, HoldATickWhenTheySayThatTheyDo) {
    const auto r = open(folder);
    for (Tick tick = 1; tick <= 20; ++tick) {
        const auto inputs = r->lend();
        inputs->push_back(mailbox::Command{ClientId(1), 3, mailbox::Bytes(100), 0});
        r->begin_tick(tick, inputs);
        wait_until_kept(tick);
        // Its hashes are not there yet: the tick has not been simulated.
        EXPECT_EQ(span_of(folder), std::make_pair(Tick(1), tick));
        r->end_tick(tick, {7});
    }
}

TEST_F(Journals, BeginAPieceWithEachSnapshotAndForgetThoseThatNoneNeeds) {
    const auto r = open(folder);
    play(*r, 1, 10);
    r->cut_journal(10);
    play(*r, 11, 20);
    r->cut_journal(20);
    play(*r, 21, 25);
    EXPECT_EQ(pieces(), 3U);
    EXPECT_EQ(span_of(folder), std::make_pair(Tick(1), Tick(25)));
    r->forget_journal(10);
    play(*r, 26, 27);
    EXPECT_EQ(span_of(folder), std::make_pair(Tick(11), Tick(27)));
    r->forget_journal(15);  // within a piece, which stays whole
    play(*r, 28, 29);
    EXPECT_EQ(span_of(folder), std::make_pair(Tick(11), Tick(29)));
    r->forget_journal(29);
    play(*r, 30, 31);
    EXPECT_EQ(span_of(folder), std::make_pair(Tick(21), Tick(31)))
        << "never the one that is written";
}

/// No file of this process may grow beyond so many bytes, for a while: a disk that takes no more.
class FileLimit {
  public:
    explicit FileLimit(rlim_t bytes) {
        ::getrlimit(RLIMIT_FSIZE, &before_);
        handler_ = std::signal(SIGXFSZ, SIG_IGN);
        const rlimit limit{bytes, before_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }

    FileLimit(const FileLimit&) = delete;
    FileLimit& operator=(const FileLimit&) = delete;

    ~FileLimit() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }

  private:
    rlimit before_{};
    void (*handler_)(int) = SIG_DFL;
};

TEST_F(Journals, ADiskThatTakesNoMoreHoldsNobodyUpAndTheNextSnapshotBeginsAnew) {
    const FileLimit limit(256U << 10U);
    const auto r = open(folder);
    play(*r, 1, 60, 8000);
    EXPECT_EQ(kept.load(), 60) << "play goes on";
    {
        const std::lock_guard lock(mutex);
        ASSERT_EQ(told.size(), 1U) << "once";
        EXPECT_NE(told[0].find("File too large"), std::string::npos) << told[0];
        EXPECT_NE(told[0].find("would lose"), std::string::npos) << told[0];
    }
    const Tick last = span_of(folder).second;
    EXPECT_GT(last, 10);
    EXPECT_LT(last, 60);
    // A snapshot of tick 60: the old piece goes before a new one wants its room.
    r->cut_journal(60);
    r->forget_journal(60);
    play(*r, 61, 75);
    EXPECT_EQ(pieces(), 1U);
    EXPECT_EQ(span_of(folder), std::make_pair(Tick(61), Tick(75)));
}

TEST_F(Journals, AreWholeAgainWhenASnapshotAfterAFailureIsOnDisk) {
    const FileLimit limit(64U << 10U);
    const auto r = open(folder);
    play(*r, 1, 3, 8000);
    EXPECT_TRUE(r->journal_is_whole());
    r->cut_journal(3);  // for a snapshot that is on disk after the failure, and is older
    play(*r, 4, 20, 8000);
    EXPECT_FALSE(r->journal_is_whole());
    r->forget_journal(3);
    play(*r, 21, 22, 8000);
    EXPECT_FALSE(r->journal_is_whole()) << "ticks after that snapshot are lost";
    r->cut_journal(22);
    write_now(*r);
    play(*r, 23, 25, 10);
    EXPECT_FALSE(r->journal_is_whole()) << "no snapshot has what was lost";
    r->forget_journal(22);
    play(*r, 26, 27, 10);
    EXPECT_TRUE(r->journal_is_whole());
    EXPECT_EQ(span_of(folder), std::make_pair(Tick(23), Tick(27)));
}

TEST_F(Journals, AreNotWholeWhereTheTickBeforeACutFailed) {
    const FileLimit limit(64U << 10U);
    const auto r = open(folder);
    play(*r, 1, 3, 8000);
    const auto inputs = r->lend();
    inputs->push_back(mailbox::Command{ClientId(1), 3, mailbox::Bytes(100000, 1), 0});
    {
        // The writer gets the tick and the cut behind it at once.
        const std::unique_lock lock(hold);
        const auto blocking = r->lend();
        r->begin_tick(4, blocking);
        wait_until_held();
        r->end_tick(4, {4});
        r->begin_tick(5, inputs);
        r->end_tick(5, {5});
        r->cut_journal(5);
    }
    wait_until_kept(5);
    EXPECT_FALSE(r->journal_is_whole()) << "the snapshot of tick 5 is not on disk";
    r->forget_journal(5);
    play(*r, 6, 7, 10);
    EXPECT_TRUE(r->journal_is_whole());
}

}  // namespace
}  // namespace zoned::recording
