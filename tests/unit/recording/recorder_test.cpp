// Recorder: it writes on a thread of its own, keeps the last seconds in a ring, and says at once
// when the disk takes no more.
#include "server/recording/recorder.h"

#include "server/recording/recording_reader.h"

#include <gtest/gtest.h>
#include <sys/mount.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <mutex>
#include <thread>

namespace zoned::recording {
namespace {

namespace fs = std::filesystem;

/// A fresh folder, and what the recorder told.
class Recorders : public testing::Test {
  protected:
    Recorders() {
        folder = testing::TempDir() + "zoned_recorder_" +
                 testing::UnitTest::GetInstance()->current_test_info()->name();
        fs::remove_all(folder);
        fs::create_directories(folder);
    }

    ~Recorders() override { fs::remove_all(folder); }

    [[nodiscard]] RecorderSettings settings() const {
        RecorderSettings s;
        s.header = RecordingHeader::of_this_build();
        s.header.config_digest = "d";
        s.ring_folder = folder + "/ring";
        s.rate_hz = 10.0;
        return s;
    }

    std::unique_ptr<Recorder> recorder(const RecorderSettings& s) {
        return std::make_unique<Recorder>(s, [this](const std::string& text) {
            const std::lock_guard lock(mutex_);
            told_.push_back(text);
        });
    }

    std::vector<std::string> told() {
        const std::lock_guard lock(mutex_);
        return told_;
    }

    /// Plays ticks, each with a message of `bytes` bytes, never faster than the writer.
    static void play(Recorder& recorder, Tick first, Tick last, std::size_t bytes = 10) {
        for (Tick tick = first; tick <= last; ++tick) {
            const auto inputs = recorder.lend();
            EXPECT_TRUE(inputs->empty());
            inputs->push_back(mailbox::Command{
                ClientId(1), 3, mailbox::Bytes(bytes, static_cast<std::uint8_t>(tick))});
            recorder.begin_tick(tick, inputs);
            await_written_inputs(10000);
            recorder.end_tick(tick, {static_cast<std::uint64_t>(tick), 5});
        }
    }

    /// First and last tick of a recording; both 0 when it cannot be read.
    static std::pair<Tick, Tick> span_of(const std::string& path, std::string* reason = nullptr) {
        RecordingReader reader;
        std::pair<Tick, Tick> span{0, 0};
        const auto opened = reader.open(path);
        EXPECT_TRUE(opened.ok()) << opened.error();
        TickRecord record;
        auto more = reader.next(record);
        for (; more.ok() && *more; more = reader.next(record)) {
            span.first = span.first == 0 ? record.tick : span.first;
            EXPECT_TRUE(span.second == 0 || record.tick == span.second + 1);
            span.second = record.tick;
        }
        if (reason != nullptr) {
            *reason = more.ok() ? "" : more.error();
        }
        return span;
    }

    std::string folder;

  private:
    std::mutex mutex_;
    std::vector<std::string> told_;
};

TEST_F(Recorders, WriteARunThatIsReadBack) {
    RecorderSettings s = settings();
    s.file = folder + "/run.zrec";
    const auto r = recorder(s);
    ASSERT_TRUE(r->open().ok());
    play(*r, 1, 200);
    ASSERT_TRUE(r->close().ok());
    std::string reason;
    EXPECT_EQ(span_of(s.file, &reason), std::make_pair(Tick(1), Tick(200)));
    EXPECT_EQ(reason, "");
    EXPECT_EQ(r->figures().ticks, 200U);
    EXPECT_EQ(r->figures().failures, 0U);
    EXPECT_EQ(r->figures().bytes, fs::file_size(s.file));
    EXPECT_TRUE(told().empty());
}

TEST_F(Recorders, GiveTheWriterTheInputsOfATickBeforeItIsSimulated) {
    RecorderSettings s = settings();
    s.file = folder + "/run.zrec";
    const auto r = recorder(s);
    ASSERT_TRUE(r->open().ok());
    play(*r, 1, 3);
    const auto inputs = r->lend();
    inputs->push_back(mailbox::Freeze{true});
    r->begin_tick(4, inputs);
    await_written_inputs(10000);
    // Here the process would die. What is on disk by now:
    RecordingReader reader;
    ASSERT_TRUE(reader.open(s.file).ok());
    TickRecord record;
    for (Tick tick = 1; tick <= 4; ++tick) {
        ASSERT_TRUE(reader.next(record).value());
        EXPECT_EQ(record.tick, tick);
        EXPECT_EQ(record.hashes.empty(), tick == 4);
    }
    EXPECT_EQ(record.items.size(), 1U);
    EXPECT_FALSE(reader.next(record).ok());
}

TEST_F(Recorders, KeepAtLeastTheLastSecondsInTheRing) {
    RecorderSettings s = settings();
    s.ring_s = 4.0;  // 40 ticks
    {
        const auto r = recorder(s);
        ASSERT_TRUE(r->open().ok());
        play(*r, 1, 333);
        const auto [first, last] = span_of(s.ring_folder);
        EXPECT_LE(first, 294);
        EXPECT_GE(first, 270) << "and not much more";
        EXPECT_EQ(last, 333);
    }  // dies
    const auto r = recorder(s);
    ASSERT_TRUE(r->open().ok());
    ASSERT_FALSE(r->kept_ring().empty()) << "an earlier run did not end well";
    std::string reason;
    EXPECT_EQ(span_of(r->kept_ring(), &reason).second, 333);
    EXPECT_NE(reason.find("without an end mark"), std::string::npos);
    play(*r, 1, 10);
    EXPECT_EQ(span_of(s.ring_folder), std::make_pair(Tick(1), Tick(10)));
    ASSERT_TRUE(r->close().ok());
    EXPECT_TRUE(fs::is_empty(s.ring_folder)) << "a run that ends well needs none";
    const auto next = recorder(s);
    ASSERT_TRUE(next->open().ok());
    EXPECT_TRUE(next->kept_ring().empty());
}

TEST_F(Recorders, KeepTheRingBackToTheOlderOfTwoStates) {
    RecorderSettings s = settings();
    s.ring_s = 4.0;  // 40 ticks, in pieces of 10
    const auto r = recorder(s);
    ASSERT_TRUE(r->open().ok());
    const auto put_state = [&](Tick tick) {
        r->cut_ring(tick);
        const RecordedState state{tick, {1, 2, 3}};
        ASSERT_TRUE(
            RecordingFile().open(ring_state_file(s.ring_folder, tick), s.header, &state).ok());
    };
    const auto begins = [&] {
        RecordingReader reader;
        EXPECT_TRUE(reader.open(s.ring_folder).ok());
        return reader.state() ? reader.state()->tick : 0;
    };
    play(*r, 1, 64);
    put_state(64);
    play(*r, 65, 70);
    r->keep_ring_from(64);
    play(*r, 71, 124);
    EXPECT_EQ(begins(), 64);
    EXPECT_EQ(span_of(s.ring_folder), std::make_pair(Tick(65), Tick(124)));
    put_state(124);
    play(*r, 125, 130);
    r->keep_ring_from(64);
    play(*r, 131, 170);
    // The second state lies on the way, and is passed over.
    EXPECT_EQ(span_of(s.ring_folder), std::make_pair(Tick(65), Tick(170)));
    r->keep_ring_from(124);
    play(*r, 171, 190);
    EXPECT_EQ(begins(), 124);
    EXPECT_FALSE(fs::exists(ring_state_file(s.ring_folder, 64)));
    EXPECT_EQ(span_of(s.ring_folder), std::make_pair(Tick(125), Tick(190)));
    // No state follows: the ring is one of inputs again.
    play(*r, 191, 400);
    EXPECT_EQ(begins(), 0);
    EXPECT_GE(span_of(s.ring_folder).first, 400 - 70);
    put_state(400);
    std::ofstream(ring_state_file(s.ring_folder, 410) + ".part") << "of a copy that was stopped";
    ASSERT_TRUE(r->close().ok());
    EXPECT_TRUE(fs::is_empty(s.ring_folder)) << "a run that ends well needs no state";
}

TEST_F(Recorders, ShareNoRingWithAnotherServer) {
    RecorderSettings s = settings();
    s.ring_s = 4.0;
    const auto first = recorder(s);
    ASSERT_TRUE(first->open().ok());
    play(*first, 1, 5);
    const auto second = recorder(s);
    EXPECT_TRUE(second->open().ok()) << "play goes on without";
    EXPECT_TRUE(first->keeps_ring());
    EXPECT_FALSE(second->keeps_ring());
    ASSERT_EQ(told().size(), 1U);
    EXPECT_NE(told()[0].find("another server"), std::string::npos);
    EXPECT_EQ(second->figures().failures, 1U);
    play(*second, 1, 5);
    EXPECT_TRUE(second->close().ok());
    EXPECT_EQ(span_of(s.ring_folder), std::make_pair(Tick(1), Tick(5)))
        << "the first keeps its own";
}

TEST_F(Recorders, TellAtOnceWhenTheDiskIsFullAndLeaveWholeTicks) {
    const std::string small = folder + "/small";
    fs::create_directories(small);
    if (::mount("none", small.c_str(), "tmpfs", 0, "size=256k") != 0) {
        GTEST_SKIP() << "only root may mount a small file system";
    }
    RecorderSettings s = settings();
    s.file = small + "/run.zrec";
    {
        const auto r = recorder(s);
        ASSERT_TRUE(r->open().ok());
        play(*r, 1, 100, 8000);
        for (int i = 0; i < 1000 && told().empty(); ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        ASSERT_EQ(told().size(), 1U) << "once";
        EXPECT_NE(told()[0].find("No space left"), std::string::npos) << told()[0];
        EXPECT_EQ(r->figures().failures, 1U);
        const auto closed = r->close();
        ASSERT_FALSE(closed.ok());
        EXPECT_NE(closed.error().find("No space left"), std::string::npos);
        std::string reason;
        const auto [first, last] = span_of(s.file, &reason);
        EXPECT_EQ(first, 1);
        EXPECT_GT(last, 10);
        EXPECT_NE(reason.find("without an end mark"), std::string::npos) << reason;
    }
    EXPECT_EQ(::umount(small.c_str()), 0);
}

TEST_F(Recorders, EndTheRecordingWhenTheDiskStaysBehind) {
    RecorderSettings s = settings();
    s.file = folder + "/run.zrec";
    const auto r = recorder(s);
    ASSERT_TRUE(r->open().ok());
    // More than ten seconds of ticks in no time, each of them large, while the writer encodes.
    const auto inputs = r->lend();
    inputs->push_back(mailbox::Command{ClientId(1), 3, mailbox::Bytes(256 << 10)});
    for (Tick tick = 1; tick <= 5000; ++tick) {
        r->begin_tick(tick, inputs);
        r->end_tick(tick, {1});
    }
    const auto closed = r->close();
    ASSERT_FALSE(closed.ok());
    EXPECT_NE(closed.error().find("behind"), std::string::npos) << closed.error();
    EXPECT_EQ(r->figures().failures, 1U);
    ASSERT_EQ(told().size(), 1U);
    std::string reason;
    EXPECT_GE(span_of(s.file, &reason).second, 1) << "no tick is missing before the end";
}

/// Carries out a wish, and waits for its answer.
template <class Wish>
core::Result<std::string> answer_to(Wish wish) {
    std::promise<core::Result<std::string>> answer;
    wish([&answer](const core::Result<std::string>& result) { answer.set_value(result); });
    return answer.get_future().get();
}

core::Result<std::string> stop(Recorder& r) {
    return answer_to([&](RecordingAnswer answer) { r.stop_file(std::move(answer)); });
}

/// With a state as the world might have it.
core::Result<std::string> start(Recorder& r, const std::string& file, Tick tick) {
    return answer_to([&](RecordingAnswer answer) {
        r.start_file(file, {tick, {1, 2, static_cast<std::uint8_t>(tick)}}, std::move(answer));
    });
}

/// The first bytes of the state that a recording begins with, and its tick.
RecordedState state_of(const std::string& file) {
    RecordingReader reader;
    EXPECT_TRUE(reader.open(file).ok());
    return reader.state().value_or(RecordedState{});
}

core::Result<std::string> snapshot(Recorder& r, const std::string& file) {
    return answer_to([&](RecordingAnswer answer) { r.snapshot(file, std::move(answer)); });
}

using Span = std::pair<Tick, Tick>;

TEST_F(Recorders, EndAFileAndBeginAnotherWithTheStateOfThatTick) {
    RecorderSettings s = settings();
    s.file = folder + "/a.zrec";
    const auto r = recorder(s);
    ASSERT_TRUE(r->open().ok());
    play(*r, 1, 20);
    EXPECT_FALSE(start(*r, folder + "/b.zrec", 20).ok()) << "one is recorded already";
    const auto ended = stop(*r);
    ASSERT_TRUE(ended.ok()) << ended.error();
    EXPECT_NE(ended->find("ticks 1 to 20"), std::string::npos) << *ended;
    EXPECT_FALSE(stop(*r).ok()) << "nothing is recorded";
    play(*r, 21, 300);
    std::string reason;
    EXPECT_EQ(span_of(s.file, &reason), Span(1, 20));
    EXPECT_EQ(reason, "");
    const std::string next = folder + "/made/b.zrec";
    const auto begun = start(*r, next, 300);
    ASSERT_TRUE(begun.ok()) << begun.error();
    EXPECT_NE(begun->find("from tick 301 on"), std::string::npos) << *begun;
    const std::string copy = folder + "/copy.zrec";
    EXPECT_FALSE(snapshot(*r, copy).ok()) << "it holds no tick yet";
    play(*r, 301, 340);
    const auto taken = snapshot(*r, copy);
    ASSERT_TRUE(taken.ok()) << taken.error();
    EXPECT_NE(taken->find("ticks 301 to 340"), std::string::npos) << *taken;
    ASSERT_TRUE(r->close().ok());
    for (const std::string& file : {next, copy}) {
        EXPECT_EQ(span_of(file, &reason), Span(301, 340));
        EXPECT_EQ(reason, "");
        EXPECT_EQ(state_of(file).tick, 300);
        EXPECT_EQ(state_of(file).bytes, (std::vector<std::uint8_t>{1, 2, 44}));
    }
    EXPECT_EQ(state_of(s.file).tick, 0);
    EXPECT_EQ(span_of(s.file), Span(1, 20)) << "the first stays as it was";
}

TEST_F(Recorders, SnapshotNoRunThatNoReplayCouldStartWith) {
    RecorderSettings s = settings();
    s.ring_s = 2.0;  // 20 ticks
    const auto r = recorder(s);
    ASSERT_TRUE(r->open().ok());
    play(*r, 1, 100);
    const std::string file = folder + "/late.zrec";
    const auto taken = snapshot(*r, file);
    ASSERT_FALSE(taken.ok());
    EXPECT_NE(taken.error().find("recording.ring_s"), std::string::npos) << taken.error();
    EXPECT_FALSE(fs::exists(file));
    EXPECT_FALSE(fs::exists(file + ".part"));
}

TEST_F(Recorders, SnapshotTheRunFromTheFileAndFromTheRing) {
    RecorderSettings s = settings();
    s.file = folder + "/run.zrec";
    s.ring_s = 100.0;
    const auto r = recorder(s);
    ASSERT_TRUE(r->open().ok());
    EXPECT_FALSE(snapshot(*r, folder + "/none.zrec").ok()) << "no tick has run";
    play(*r, 1, 50);
    const std::string first = folder + "/first.zrec";
    const auto taken = snapshot(*r, first);
    ASSERT_TRUE(taken.ok()) << taken.error();
    EXPECT_NE(taken->find("ticks 1 to 50"), std::string::npos) << *taken;
    EXPECT_FALSE(snapshot(*r, first).ok()) << "it would replace one";
    play(*r, 51, 60);
    ASSERT_TRUE(stop(*r).ok());
    play(*r, 61, 70);
    const std::string second = folder + "/second.zrec";
    const auto again = snapshot(*r, second);
    ASSERT_TRUE(again.ok()) << again.error();
    std::string reason;
    EXPECT_EQ(span_of(first, &reason), Span(1, 50));
    EXPECT_EQ(reason, "");
    EXPECT_EQ(span_of(second, &reason), Span(1, 70));
    EXPECT_EQ(reason, "");
    EXPECT_FALSE(fs::exists(second + ".part"));
}

/// A recording that ends within a tick would look as if the server had died there.
TEST_F(Recorders, CarryOutWishesBetweenTwoTicks) {
    RecorderSettings s = settings();
    s.file = folder + "/run.zrec";
    s.ring_s = 100.0;
    const auto r = recorder(s);
    ASSERT_TRUE(r->open().ok());
    play(*r, 1, 9);
    r->begin_tick(10, r->lend());
    await_written_inputs(10000);
    std::promise<std::string> answer;
    auto said = answer.get_future();
    r->stop_file([&](const core::Result<std::string>& result) {
        answer.set_value(result.ok() ? *result : result.error());
    });
    EXPECT_EQ(said.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
    // The loop may stand still after this tick: its end is enough.
    r->end_tick(10, {10, 5});
    ASSERT_EQ(said.wait_for(std::chrono::seconds(10)), std::future_status::ready);
    EXPECT_NE(said.get().find("ticks 1 to 10"), std::string::npos);
    RecordingReader reader;
    ASSERT_TRUE(reader.open(s.file).ok());
    TickRecord record;
    for (Tick tick = 1; tick <= 10; ++tick) {
        ASSERT_TRUE(reader.next(record).value());
        EXPECT_FALSE(record.hashes.empty());
    }
    EXPECT_FALSE(reader.next(record).value());
    ASSERT_TRUE(r->close().ok());
    EXPECT_FALSE(snapshot(*r, folder + "/late.zrec").ok()) << "answered though it is over";
}

}  // namespace
}  // namespace zoned::recording
