#include "server/recording/recording_reader.h"

#include "server/recording/crash_ring.h"
#include "server/recording/record_items.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>

namespace zoned::recording {

namespace {

using core::Result;
namespace fs = std::filesystem;

struct CloseStream {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

using Stream = std::unique_ptr<std::FILE, CloseStream>;

/// Stem of the piece that begins with tick 1.
constexpr const char* kFromTheBeginning = "000000000001";

/// The pieces of a recording in their order: their names begin with the number of a tick.
std::vector<std::string> pieces_of(const std::string& folder) {
    std::vector<std::string> files;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        if (entry.path().extension() == ".zrec" && entry.is_regular_file(error)) {
            files.push_back(entry.path().string());
        }
    }
    std::sort(files.begin(), files.end());
    const auto state = std::find_if(files.begin(), files.end(), is_ring_state);
    if (state != files.end() && fs::path(files.front()).stem() != kFromTheBeginning) {
        files.erase(files.begin(), state);
    }
    return files;
}

}  // namespace

struct RecordingReader::Impl {
    std::string name;  ///< as it was opened
    std::vector<std::string> files;
    std::size_t file = 0;  ///< the one that is read
    Stream stream;
    RecordingHeader header;
    std::optional<RecordedState> state;
    std::uint64_t total = 0;
    std::uint64_t size = 0;  ///< of the file
    std::uint64_t at = 0;    ///< beginning of the next frame
    std::uint64_t file_ticks = 0;
    bool sought = false;  ///< ticks of this file were passed over
    bool ended = false;
    std::optional<Tick> last;
    std::string failure;  ///< found while the tick before it was read; it is said next
    std::optional<FrameHead> peeked;
    std::string payload;

    [[nodiscard]] std::string text_of(const std::string& what) const {
        const std::string where = files.size() > 1 ? files[file] : name;
        return "the recording '" + where + "' " + what + " (byte " + std::to_string(at) + ", " +
               (last ? "the last whole tick is " + std::to_string(*last) : "before any tick") + ")";
    }

    [[nodiscard]] Result<bool> damaged(const std::string& what) const {
        return Result<bool>::failure(text_of(what));
    }

    bool read(void* out, std::size_t bytes) {
        return std::fread(out, 1, bytes, stream.get()) == bytes;
    }

    Result<bool> open_piece();
    Result<bool> peek();
    Result<bool> take();
    Result<bool> skip();
    Result<bool> read_header();
    Result<bool> read_state();
    Result<bool> check_end();
    Result<bool> read_tick(TickRecord& record);
    Result<bool> kept(Result<bool> outcome);
    bool read_items(TickRecord& record);
    void read_hashes(Tick tick, TickRecord& record);
};

/// Opens the file `files[file]` and reads its header.
Result<bool> RecordingReader::Impl::open_piece() {
    const std::string& path = files[file];
    errno = 0;
    stream.reset(std::fopen(path.c_str(), "rb"));
    if (!stream || std::fseek(stream.get(), 0, SEEK_END) != 0) {
        return Result<bool>::failure("cannot read the recording '" + path +
                                     "': " + std::strerror(errno));
    }
    const long bytes = std::ftell(stream.get());
    std::rewind(stream.get());
    size = bytes < 0 ? 0 : static_cast<std::uint64_t>(bytes);
    MagicBytes magic{};
    std::optional<std::uint32_t> format;
    if (size >= kMagicBytes && read(magic.data(), magic.size())) {
        format = format_of(magic);
    }
    if (!format) {
        return Result<bool>::failure("'" + path + "' is no recording of zoned");
    }
    if (*format != kRecordingFormat) {
        return Result<bool>::failure("the recording '" + path + "' has format " +
                                     std::to_string(*format) + ", this program (" +
                                     RecordingHeader::of_this_build().program + ") reads format " +
                                     std::to_string(kRecordingFormat));
    }
    total += size;
    at = kMagicBytes;
    file_ticks = 0;
    sought = false;
    peeked.reset();
    return read_header();
}

/// True: `peeked` is the head of the next frame, whose payload lies within the file. False: not a
/// byte is left.
Result<bool> RecordingReader::Impl::peek() {
    if (peeked) {
        return true;
    }
    if (at == size) {
        return false;
    }
    FrameHeadBytes bytes{};
    if (size - at < kFrameHeadBytes || !read(bytes.data(), bytes.size())) {
        return damaged("is cut off within a frame");
    }
    const std::optional<FrameHead> head = decode_head(bytes);
    if (!head) {
        return damaged("is corrupt: the head of a frame does not match its checksum");
    }
    if (head->length > kMaxPayloadBytes) {
        return damaged("is corrupt: a frame of " + std::to_string(head->length) + " bytes");
    }
    if (head->length > size - at - kFrameHeadBytes) {
        return damaged("is cut off within a frame");
    }
    peeked = head;
    return true;
}

/// Reads the payload of the frame that was peeked.
Result<bool> RecordingReader::Impl::take() {
    payload.resize(peeked->length);
    if (!read(payload.data(), payload.size())) {
        return damaged("cannot be read");
    }
    if (checksum_of(payload) != peeked->checksum) {
        return damaged("is corrupt: the content of a frame does not match its checksum");
    }
    at += kFrameHeadBytes + peeked->length;
    peeked.reset();
    return true;
}

/// Passes over the payload of the frame that was peeked.
Result<bool> RecordingReader::Impl::skip() {
    if (std::fseek(stream.get(), static_cast<long>(peeked->length), SEEK_CUR) != 0) {
        return damaged("cannot be read");
    }
    at += kFrameHeadBytes + peeked->length;
    peeked.reset();
    return true;
}

Result<bool> RecordingReader::Impl::read_header() {
    const Result<bool> first = peek();
    if (!first.ok()) {
        return first;
    }
    proto::RecordingHeader from;
    if (!*first || peeked->kind != FrameKind::kHeader) {
        return damaged("has no header");
    }
    const Result<bool> taken = take();
    if (!taken.ok()) {
        return taken;
    }
    if (!from.ParseFromString(payload)) {
        return damaged("is corrupt: its header does not parse");
    }
    if (file > 0 && from.config_digest() != header.config_digest) {
        return damaged("is a piece of another run");
    }
    header.generation = from.generation();
    header.program = from.program();
    header.target = from.target();
    header.compiler = from.compiler();
    header.config_text = from.config_text();
    header.config_digest = from.config_digest();
    header.seed = from.seed();
    return read_state();
}

/// A first piece may go on with the state of the world. That of a later one follows from the ticks
/// before it.
Result<bool> RecordingReader::Impl::read_state() {
    const Result<bool> more = peek();
    if (!more.ok() || !*more || peeked->kind != FrameKind::kState) {
        return more.ok() ? Result<bool>(true) : more;
    }
    if (file > 0) {
        return skip();
    }
    const Tick tick = peeked->tick;
    const Result<bool> taken = take();
    if (taken.ok()) {
        state = RecordedState{tick, {payload.begin(), payload.end()}};
        last = tick;
        payload = {};
    }
    return taken;
}

Result<bool> RecordingReader::Impl::check_end() {
    const Result<bool> taken = take();
    if (!taken.ok()) {
        return taken;
    }
    proto::RecordingEnd end;
    if (!end.ParseFromString(payload) || (!sought && end.ticks() != file_ticks)) {
        return damaged("is corrupt: its end mark counts other ticks");
    }
    if (at != size || file + 1 != files.size()) {
        return damaged("is corrupt: something follows its end mark");
    }
    ended = true;
    return false;
}

bool RecordingReader::Impl::read_items(TickRecord& record) {
    proto::RecordedInputs inputs;
    if (!inputs.ParseFromString(payload)) {
        return false;
    }
    record.items.resize(static_cast<std::size_t>(inputs.items_size()));
    for (int i = 0; i < inputs.items_size(); ++i) {
        if (!from_record(inputs.items(i), record.items[static_cast<std::size_t>(i)])) {
            return false;
        }
    }
    return true;
}

/// The hashes after a tick whose inputs were read. Without them the server may have stopped within
/// the tick: its inputs are given all the same, and a failure is said by the next call.
void RecordingReader::Impl::read_hashes(Tick tick, TickRecord& record) {
    const Result<bool> after = peek();
    if (!after.ok()) {
        failure = after.error();
        return;
    }
    if (!*after || peeked->kind == FrameKind::kEnd) {
        return;
    }
    if (peeked->kind != FrameKind::kHashes || peeked->tick != tick) {
        failure = text_of("is corrupt: a tick has no hashes");
        return;
    }
    const Result<bool> taken = take();
    proto::RecordedHashes hashes;
    if (!taken.ok() || !hashes.ParseFromString(payload)) {
        failure = taken.ok() ? text_of("is corrupt: hashes do not parse") : taken.error();
        return;
    }
    record.hashes.assign(hashes.zones().begin(), hashes.zones().end());
    last = tick;
}

RecordingReader::RecordingReader() : impl_(std::make_unique<Impl>()) {
}

RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;
RecordingReader::~RecordingReader() = default;

Result<bool> RecordingReader::open(const std::string& path) {
    impl_ = std::make_unique<Impl>();
    impl_->name = path;
    std::error_code error;
    if (fs::is_directory(path, error)) {
        impl_->files = pieces_of(path);
        if (impl_->files.empty()) {
            return Result<bool>::failure("the folder '" + path + "' holds no recording (*.zrec)");
        }
    } else {
        impl_->files = {path};
    }
    return impl_->open_piece();
}

const RecordingHeader& RecordingReader::header() const {
    return impl_->header;
}

const std::optional<RecordedState>& RecordingReader::state() const {
    return impl_->state;
}

std::uint64_t RecordingReader::bytes() const {
    return impl_->total;
}

Result<bool> RecordingReader::check_build() const {
    const RecordingHeader& from = impl_->header;
    const RecordingHeader own = RecordingHeader::of_this_build();
    if (from.generation != own.generation) {
        return Result<bool>::failure(
            "the recording '" + impl_->name + "' comes from zoned " + from.program +
            " with simulation generation " + std::to_string(from.generation) + ", this is zoned " +
            own.program + " with generation " + std::to_string(own.generation) +
            "; replay it with a build of its own time");
    }
    return true;
}

/// The next tick; false: the recording ends in good order.
Result<bool> RecordingReader::Impl::read_tick(TickRecord& record) {
    Result<bool> more = peek();
    while (more.ok() && !*more && file + 1 < files.size()) {
        ++file;
        more = open_piece();
        if (more.ok()) {
            more = peek();
        }
    }
    if (!more.ok()) {
        return more;
    }
    if (!*more) {
        return damaged("ends without an end mark: the server did not come to close it");
    }
    if (peeked->kind == FrameKind::kEnd) {
        return check_end();
    }
    const Tick tick = peeked->tick;
    if (peeked->kind != FrameKind::kInputs || (last && tick <= *last)) {
        return damaged(peeked->kind != FrameKind::kInputs ? "is corrupt: a tick has no inputs"
                                                          : "is corrupt: ticks do not ascend");
    }
    const Result<bool> taken = take();
    if (!taken.ok()) {
        return taken;
    }
    record.tick = tick;
    record.hashes.clear();
    if (!read_items(record)) {
        return damaged("is corrupt: a frame holds no valid inputs");
    }
    ++file_ticks;
    read_hashes(tick, record);
    return true;
}

/// A damage stays one, wherever the stream stands after it.
Result<bool> RecordingReader::Impl::kept(Result<bool> outcome) {
    if (!outcome.ok()) {
        failure = outcome.error();
    }
    return outcome;
}

Result<bool> RecordingReader::seek(Tick tick) {
    Impl& r = *impl_;
    while (r.failure.empty() && !r.ended) {
        const Result<bool> more = r.peek();
        if (!more.ok()) {
            return r.kept(more);
        }
        if (!*more) {
            if (r.file + 1 == r.files.size()) {
                return false;
            }
            ++r.file;
            const Result<bool> opened = r.open_piece();
            if (!opened.ok()) {
                return r.kept(opened);
            }
            continue;
        }
        if (r.peeked->kind == FrameKind::kInputs && r.peeked->tick >= tick) {
            return true;
        }
        if (r.peeked->kind == FrameKind::kEnd) {
            return false;
        }
        r.sought = true;
        const Result<bool> passed = r.skip();
        if (!passed.ok()) {
            return r.kept(passed);
        }
    }
    return false;
}

Result<bool> RecordingReader::next(TickRecord& record) {
    Impl& r = *impl_;
    if (!r.stream) {
        return Result<bool>::failure("no recording is open");
    }
    if (!r.failure.empty()) {
        return Result<bool>::failure(r.failure);
    }
    if (r.ended) {
        return false;
    }
    return r.kept(r.read_tick(record));
}

}  // namespace zoned::recording
