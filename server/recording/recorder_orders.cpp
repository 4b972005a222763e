#include "server/recording/recorder.h"
#include "server/recording/recording_reader.h"

#include <filesystem>
#include <utility>

namespace zoned::recording {

namespace {

namespace fs = std::filesystem;
using core::Result;

constexpr const char* kNotWhole =
    "nothing is recorded, and the inputs of the last recording.ring_s go back neither to the first "
    "tick nor to a state of the world: `zoned ctl record on` begins a recording now";

std::string text_of(const std::string& file, Tick before, Tick last, std::uint64_t bytes) {
    if (last <= before) {
        return file + " holds no tick";
    }
    return file + " holds ticks " + std::to_string(before + 1) + " to " + std::to_string(last) +
           ", " + std::to_string(bytes) + " bytes";
}

/// Fails where something has this name, or its folder cannot be made.
Result<bool> make_room(const std::string& file) {
    std::error_code error;
    if (fs::exists(file, error)) {
        return Result<bool>::failure(file + " exists already");
    }
    fs::create_directories(fs::absolute(file).parent_path(), error);
    if (error) {
        return Result<bool>::failure("cannot create the folder of " + file + ": " +
                                     error.message());
    }
    return true;
}

/// Under a name of its own until it is whole.
std::string part_of(const std::string& file) {
    return file + ".part";
}

Result<bool> publish(RecordingFile& part, const std::string& file) {
    const Result<bool> closed = part.close();
    std::error_code error;
    if (closed.ok()) {
        fs::rename(part_of(file), file, error);
    }
    if (!closed.ok() || error) {
        const std::string why = closed.ok() ? error.message() : closed.error();
        fs::remove(part_of(file), error);
        return Result<bool>::failure(why);
    }
    return true;
}

/// Copies whole ticks of a recording that grows meanwhile, up to one of them.
Result<bool> copy_ticks(RecordingReader& reader, Tick last, RecordingFile& out) {
    TickRecord record;
    Tick done = reader.state() ? reader.state()->tick : 0;
    while (done < last) {
        const Result<bool> more = reader.next(record);
        if (!more.ok()) {
            return more;
        }
        if (!*more || record.tick != done + 1) {
            return Result<bool>::failure(kNotWhole);
        }
        out.add_tick(record);
        done = record.tick;
    }
    return out.error().empty() ? Result<bool>(true) : Result<bool>::failure(out.error());
}

/// A recording of its own with the ticks of another up to `last`; its text.
Result<std::string> copy_to(const std::string& from,
                            Tick last,
                            const RecordingHeader& header,
                            const std::string& file) {
    RecordingReader reader;
    Result<bool> done = reader.open(from);
    if (!done.ok()) {
        return Result<std::string>::failure(done.error());
    }
    const RecordedState* state = reader.state() ? &*reader.state() : nullptr;
    RecordingFile part;
    done = part.open(part_of(file), header, state);
    if (done.ok()) {
        done = copy_ticks(reader, last, part);
    }
    if (!done.ok()) {
        std::error_code error;
        fs::remove(part_of(file), error);
        return Result<std::string>::failure(done.error());
    }
    done = publish(part, file);
    if (!done.ok()) {
        return Result<std::string>::failure(done.error());
    }
    return text_of(file, state != nullptr ? state->tick : 0, last, part.bytes());
}

}  // namespace

void Recorder::stop_file(RecordingAnswer answer) {
    order(Wish::kStop, {}, std::move(answer));
}

void Recorder::start_file(std::string file, RecordedState state, RecordingAnswer answer) {
    const Tick tick = state.tick;
    const auto beginning = std::make_shared<const Beginning>(
        Beginning{std::move(file), std::move(state), std::move(answer)});
    if (!push({tick, nullptr, {}, Upkeep::kNone, beginning}, true)) {
        beginning->answer(Result<std::string>::failure("the disk is too far behind"));
    }
}

void Recorder::snapshot(std::string file, RecordingAnswer answer) {
    order(Wish::kSnapshot, std::move(file), std::move(answer));
}

void Recorder::order(Wish wish, std::string file, RecordingAnswer answer) {
    {
        const std::lock_guard lock(mutex_);
        if (!closing_) {
            orders_.push_back({wish, std::move(file), std::move(answer)});
            answer = nullptr;
        }
    }
    if (answer) {
        answer(Result<std::string>::failure("the server stops"));
        return;
    }
    ::sem_post(&bell_);
}

void Recorder::carry_out(std::vector<Order>& orders) {
    for (const Order& order : orders) {
        if (order.wish == Wish::kSnapshot) {
            copy_run(order);
        } else {
            order.answer(end_file());
        }
    }
    orders.clear();
}

Result<std::string> Recorder::end_file() {
    if (!file_.is_open()) {
        return Result<std::string>::failure("nothing is recorded");
    }
    const Result<bool> closed = file_.close();
    if (!closed.ok()) {
        file_failure_logged_ = true;
        return Result<std::string>::failure(closed.error());
    }
    return text_of(file_.name(), before_file_, whole_tick_, file_.bytes());
}

Result<std::string> Recorder::begin_file(const Beginning& beginning) {
    const std::string& file = beginning.file;
    if (file_.is_open() && file_.error().empty()) {
        return Result<std::string>::failure(file_.name() + " is recorded already");
    }
    Result<bool> done = make_room(file);
    if (!done.ok()) {
        return Result<std::string>::failure(done.error());
    }
    RecordingFile fresh;
    done = fresh.open(file, settings_.header, &beginning.state);
    if (!done.ok()) {
        std::error_code error;
        fs::remove(file, error);
        return Result<std::string>::failure(done.error());
    }
    file_ = std::move(fresh);
    file_failure_logged_ = false;
    before_file_ = beginning.state.tick;
    return "recording into " + file + ", from tick " + std::to_string(before_file_ + 1) + " on";
}

void Recorder::copy_run(const Order& order) {
    const bool from_file = file_.is_open() && file_.error().empty();
    const bool has_ticks = whole_tick_ > (from_file ? before_file_ : 0);
    if (!has_ticks || (!from_file && !ring_.can_be_replayed())) {
        order.answer(Result<std::string>::failure(!has_ticks ? "no tick has run yet" : kNotWhole));
        return;
    }
    if (copies_.exchange(true)) {
        order.answer(Result<std::string>::failure("another snapshot is being written"));
        return;
    }
    const Result<bool> room = make_room(order.file);
    if (!room.ok() || !from_file) {
        // Pieces of the ring go when they are old: they are copied before the next tick is written.
        order.answer(
            !room.ok() ? Result<std::string>::failure(room.error())
                       : copy_to(settings_.ring_folder, whole_tick_, settings_.header, order.file));
        copies_.store(false);
        return;
    }
    if (copier_.joinable()) {
        copier_.join();
    }
    // A long run takes long to copy: ticks are written meanwhile.
    copier_ = std::thread([this, order, from = file_.name(), last = whole_tick_] {
        const Result<std::string> copied = copy_to(from, last, settings_.header, order.file);
        copies_.store(false);
        order.answer(copied);
    });
}

}  // namespace zoned::recording
