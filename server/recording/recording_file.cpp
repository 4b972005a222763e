#include "server/recording/recording_file.h"

#include "server/recording/frequent_records.h"
#include "server/recording/record_items.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace zoned::recording {

namespace {

using core::Result;

constexpr std::size_t kBufferedBytes = 1U << 20U;

}  // namespace

// ---------------------------------------------------------------- encoder

struct FrameEncoder::Impl {
    proto::RecordingHeader header;
    proto::RecordedInputs inputs;  // one item at a time
    proto::RecordedHashes hashes;
    proto::RecordingEnd end;
    std::string frame;

    std::string_view encode_inputs(Tick tick, std::span<const mailbox::InboxItem> items);

    std::string_view encode(FrameKind kind, Tick tick, const google::protobuf::Message& message) {
        frame.assign(kFrameHeadBytes, '\0');
        if (message.ByteSizeLong() > kMaxPayloadBytes || !message.AppendToString(&frame)) {
            return {};
        }
        return with_head(kind, tick);
    }

    /// `frame` holds room for the head, and the payload.
    std::string_view with_head(FrameKind kind, Tick tick) {
        const std::string_view payload = std::string_view(frame).substr(kFrameHeadBytes);
        FrameHead head;
        head.kind = kind;
        head.length = static_cast<std::uint32_t>(payload.size());
        head.tick = tick;
        head.checksum = checksum_of(payload);
        const FrameHeadBytes bytes = encode_head(head);
        std::memcpy(frame.data(), bytes.data(), bytes.size());
        return frame;
    }
};

std::string_view FrameEncoder::Impl::encode_inputs(Tick tick,
                                                   std::span<const mailbox::InboxItem> items) {
    frame.assign(kFrameHeadBytes, '\0');
    for (const mailbox::InboxItem& item : items) {
        if (append_frequent_record(item, frame)) {
            continue;
        }
        inputs.Clear();
        to_record(item, *inputs.add_items());
        // Messages of one kind that follow each other are one message with the items of both.
        if (!inputs.AppendToString(&frame)) {
            return {};
        }
    }
    return frame.size() - kFrameHeadBytes > kMaxPayloadBytes ? std::string_view()
                                                             : with_head(FrameKind::kInputs, tick);
}

FrameEncoder::FrameEncoder() : impl_(std::make_unique<Impl>()) {
}

FrameEncoder::~FrameEncoder() = default;

std::string_view FrameEncoder::header(const RecordingHeader& header) {
    proto::RecordingHeader& out = impl_->header;
    out.set_generation(header.generation);
    out.set_program(header.program);
    out.set_target(header.target);
    out.set_compiler(header.compiler);
    out.set_config_text(header.config_text);
    out.set_config_digest(header.config_digest);
    out.set_seed(header.seed);
    return impl_->encode(FrameKind::kHeader, 0, out);
}

std::string_view FrameEncoder::inputs(Tick tick, std::span<const mailbox::InboxItem> items) {
    return impl_->encode_inputs(tick, items);
}

std::string_view FrameEncoder::hashes(Tick tick, std::span<const std::uint64_t> hashes) {
    impl_->hashes.Clear();
    for (const std::uint64_t hash : hashes) {
        impl_->hashes.add_zones(hash);
    }
    return impl_->encode(FrameKind::kHashes, tick, impl_->hashes);
}

std::string_view FrameEncoder::end(std::uint64_t ticks) {
    impl_->end.set_ticks(ticks);
    return impl_->encode(FrameKind::kEnd, 0, impl_->end);
}

std::string_view FrameEncoder::state(const RecordedState& state) {
    if (state.bytes.size() > kMaxPayloadBytes) {
        return {};
    }
    impl_->frame.assign(kFrameHeadBytes, '\0');
    impl_->frame.append(state.bytes.begin(), state.bytes.end());
    return impl_->with_head(FrameKind::kState, state.tick);
}

// ---------------------------------------------------------------- file

RecordingFile::RecordingFile(RecordingFile&& other) noexcept {
    *this = std::move(other);
}

RecordingFile& RecordingFile::operator=(RecordingFile&& other) noexcept {
    std::swap(fd_, other.fd_);
    std::swap(name_, other.name_);
    std::swap(error_, other.error_);
    std::swap(buffer_, other.buffer_);
    std::swap(written_, other.written_);
    std::swap(ticks_, other.ticks_);
    return *this;
}

RecordingFile::~RecordingFile() {
    flush();
    shut();
}

void RecordingFile::shut() {
    if (fd_ >= 0) {
        ::close(fd_);
        fd_ = -1;
    }
}

void RecordingFile::fail(const std::string& reason) {
    if (error_.empty()) {
        error_ = "cannot write the recording '" + name_ + "': " + reason;
    }
    buffer_.clear();
    // A device such as /dev/full cannot be cut; a file can.
    [[maybe_unused]] const int cut = ::ftruncate(fd_, static_cast<off_t>(written_));
}

Result<bool> RecordingFile::open(const std::string& file,
                                 const RecordingHeader& header,
                                 const RecordedState* state) {
    shut();
    name_ = file;
    error_.clear();
    buffer_.clear();
    written_ = 0;
    ticks_ = 0;
    fd_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0640);
    if (fd_ < 0) {
        return Result<bool>::failure("cannot create the recording '" + file +
                                     "': " + std::strerror(errno));
    }
    const MagicBytes magic = magic_of(kRecordingFormat);
    buffer_.assign(magic.begin(), magic.end());
    FrameEncoder encoder;
    append(encoder.header(header), false);
    if (state != nullptr) {
        append(encoder.state(*state), false);
    }
    flush();
    if (!error_.empty()) {
        return Result<bool>::failure(error_);
    }
    return true;
}

void RecordingFile::append(std::string_view frame, bool begins_tick) {
    if (fd_ < 0 || !error_.empty()) {
        return;
    }
    if (frame.empty()) {
        flush();
        fail("a tick, or the state of the world, is larger than 256 MiB");
        return;
    }
    ticks_ += begins_tick ? 1 : 0;
    buffer_ += frame;
    if (buffer_.size() >= kBufferedBytes) {
        flush();
    }
}

void RecordingFile::flush() {
    if (fd_ < 0 || !error_.empty()) {
        return;
    }
    std::string_view rest = buffer_;
    while (!rest.empty()) {
        const ssize_t n = ::write(fd_, rest.data(), rest.size());
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            fail(n < 0 ? std::strerror(errno) : "the system takes no byte");
            return;
        }
        rest.remove_prefix(static_cast<std::size_t>(n));
    }
    written_ += buffer_.size();
    buffer_.clear();
}

void RecordingFile::sync() {
    flush();
    if (fd_ >= 0 && error_.empty() && ::fdatasync(fd_) != 0 && errno != EINVAL && errno != EROFS) {
        fail(std::strerror(errno));
    }
}

void RecordingFile::give_up(const std::string& reason) {
    flush();
    if (fd_ >= 0) {
        fail(reason);
    }
}

void RecordingFile::add_tick(const TickRecord& record) {
    FrameEncoder encoder;
    append(encoder.inputs(record.tick, record.items), true);
    if (!record.hashes.empty()) {
        append(encoder.hashes(record.tick, record.hashes), false);
    }
}

Result<bool> RecordingFile::close() {
    if (fd_ < 0) {
        return Result<bool>::failure("no recording is open");
    }
    FrameEncoder encoder;
    append(encoder.end(ticks_), false);
    flush();
    if (error_.empty() && ::fsync(fd_) != 0 && errno != EINVAL && errno != EROFS) {
        fail(std::strerror(errno));
    }
    const int fd = std::exchange(fd_, -1);
    if (::close(fd) != 0 && error_.empty()) {
        error_ = "cannot write the recording '" + name_ + "': " + std::strerror(errno);
    }
    if (!error_.empty()) {
        return Result<bool>::failure(error_);
    }
    return true;
}

}  // namespace zoned::recording
