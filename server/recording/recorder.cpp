#include "server/recording/recorder.h"

#include "server/recording/record_items.h"
#include "shared/core/state_hash.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace zoned::recording {

namespace {

using core::Result;

constexpr char kMagic[8] = {'Z', 'O', 'N', 'E', 'D', 'R', 'E', 'C'};
constexpr std::size_t kHeadBytes = 12;  // length and checksum of a frame
constexpr std::size_t kBufferBytes = 1u << 20;
/// A damaged length must not make the reader ask for all memory.
constexpr std::uint64_t kMaxFrameBytes = 1u << 28;

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

using File = std::unique_ptr<std::FILE, CloseFile>;

std::uint64_t checksum(const std::string& payload) {
    core::StateHash hash;
    hash.add_bytes({reinterpret_cast<const std::uint8_t*>(payload.data()), payload.size()});
    return hash.value();
}

void put_number(std::uint64_t value, std::size_t bytes, unsigned char* out) {
    for (std::size_t i = 0; i < bytes; ++i) {
        out[i] = static_cast<unsigned char>(value >> (8 * i));
    }
}

std::uint64_t get_number(const unsigned char* in, std::size_t bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
        value |= static_cast<std::uint64_t>(in[i]) << (8 * i);
    }
    return value;
}

std::string system_reason() {
    return errno == 0 ? "unknown reason" : std::strerror(errno);
}

}  // namespace

RecordingHeader RecordingHeader::of_this_build() {
    RecordingHeader header;
    header.target = ZONED_TARGET_NAME;
#if defined(__clang__)
    header.compiler = "clang++ " __clang_version__;
#else
    header.compiler = "g++ " __VERSION__;
#endif
    return header;
}

// ---------------------------------------------------------------- writer

struct RecordingWriter::Impl {
    File file;
    std::string name;
    std::string error;
    std::uint64_t bytes = 0;
    std::uint64_t ticks = 0;
    // Kept between ticks, so that their memory is reused.
    proto::RecordingFrame frame;
    std::string payload;

    void write(const void* data, std::size_t size) {
        if (!error.empty() || !file) {
            return;
        }
        errno = 0;
        if (std::fwrite(data, 1, size, file.get()) != size) {
            error = "cannot write the recording '" + name + "': " + system_reason();
            return;
        }
        bytes += size;
    }

    void write_frame() {
        frame.SerializeToString(&payload);
        if (payload.size() > kMaxFrameBytes && error.empty()) {
            error = "a tick of the recording '" + name + "' is larger than 256 MiB";
        }
        unsigned char head[kHeadBytes];
        put_number(payload.size(), 4, head);
        put_number(checksum(payload), 8, head + 4);
        write(head, sizeof(head));
        write(payload.data(), payload.size());
    }
};

RecordingWriter::RecordingWriter() : impl_(std::make_unique<Impl>()) {
}

RecordingWriter::RecordingWriter(RecordingWriter&&) noexcept = default;
RecordingWriter& RecordingWriter::operator=(RecordingWriter&&) noexcept = default;
RecordingWriter::~RecordingWriter() = default;

Result<bool> RecordingWriter::open(const std::string& file, const RecordingHeader& header) {
    impl_ = std::make_unique<Impl>();
    impl_->name = file;
    errno = 0;
    impl_->file.reset(std::fopen(file.c_str(), "wb"));
    if (!impl_->file) {
        return Result<bool>::failure("cannot create the recording '" + file +
                                     "': " + system_reason());
    }
    std::setvbuf(impl_->file.get(), nullptr, _IOFBF, kBufferBytes);
    impl_->write(kMagic, sizeof(kMagic));
    proto::RecordingHeader& out = *impl_->frame.mutable_header();
    out.set_format(kRecordingFormat);
    out.set_generation(header.generation);
    out.set_target(header.target);
    out.set_compiler(header.compiler);
    out.set_config_text(header.config_text);
    out.set_config_digest(header.config_digest);
    out.set_seed(header.seed);
    impl_->write_frame();
    if (!impl_->error.empty()) {
        return Result<bool>::failure(impl_->error);
    }
    return true;
}

void RecordingWriter::add_tick(Tick tick, std::span<const ZoneTick> zones) {
    proto::RecordedTick& out = *impl_->frame.mutable_tick();
    out.Clear();
    out.set_tick(tick);
    for (const ZoneTick& zone : zones) {
        proto::RecordedZone& z = *out.add_zones();
        z.set_zone(zone.zone.value);
        z.set_hash(zone.hash);
        for (const mailbox::InboxItem& item : zone.inbox) {
            to_record(item, *z.add_items());
        }
    }
    impl_->write_frame();
    ++impl_->ticks;
}

Result<bool> RecordingWriter::close() {
    if (!impl_->file) {
        return Result<bool>::failure("no recording is open");
    }
    impl_->frame.mutable_end()->set_ticks(impl_->ticks);
    impl_->write_frame();
    errno = 0;
    std::FILE* file = impl_->file.release();
    if (std::fclose(file) != 0 && impl_->error.empty()) {
        impl_->error = "cannot write the recording '" + impl_->name + "': " + system_reason();
    }
    if (!impl_->error.empty()) {
        return Result<bool>::failure(impl_->error);
    }
    return true;
}

std::uint64_t RecordingWriter::bytes() const {
    return impl_->bytes;
}

// ---------------------------------------------------------------- reader

struct RecordingReader::Impl {
    File file;
    std::string name;
    RecordingHeader header;
    std::uint64_t size = 0;
    std::uint64_t at = 0;
    std::uint64_t ticks = 0;
    bool ended = false;
    Tick last = 0;
    proto::RecordingFrame frame;
    std::string payload;

    [[nodiscard]] Result<bool> damaged(const std::string& what) const {
        return Result<bool>::failure("the recording '" + name + "' " + what + " (byte " +
                                     std::to_string(at) + ", after " + std::to_string(ticks) +
                                     " ticks)");
    }

    bool read(void* out, std::size_t bytes) {
        return std::fread(out, 1, bytes, file.get()) == bytes;
    }

    /// True: `frame` is the next one. False: not a byte is left.
    Result<bool> read_frame() {
        if (at == size) {
            return false;
        }
        unsigned char head[kHeadBytes];
        if (size - at < kHeadBytes || !read(head, sizeof(head))) {
            return damaged("is cut off within a frame");
        }
        const std::uint64_t length = get_number(head, 4);
        if (length > kMaxFrameBytes) {
            return damaged("is corrupt: a frame of " + std::to_string(length) + " bytes");
        }
        if (length > size - at - kHeadBytes) {
            return damaged("is cut off within a frame");
        }
        payload.resize(length);
        if (!read(payload.data(), length)) {
            return damaged("cannot be read");
        }
        if (checksum(payload) != get_number(head + 4, 8)) {
            return damaged("is corrupt: a checksum does not match");
        }
        if (!frame.ParseFromString(payload)) {
            return damaged("is corrupt: a frame does not parse");
        }
        at += kHeadBytes + length;
        return true;
    }

    Result<bool> read_header() {
        const Result<bool> first = read_frame();
        if (!first.ok()) {
            return first;
        }
        if (!first.value() || !frame.has_header()) {
            return damaged("has no header");
        }
        const proto::RecordingHeader& from = frame.header();
        if (from.format() != kRecordingFormat) {
            return damaged("has format " + std::to_string(from.format()) + ", this program reads " +
                           std::to_string(kRecordingFormat));
        }
        header.generation = from.generation();
        header.target = from.target();
        header.compiler = from.compiler();
        header.config_text = from.config_text();
        header.config_digest = from.config_digest();
        header.seed = from.seed();
        return check_build();
    }

    /// Hashes agree only between builds of one simulation generation for one processor target.
    [[nodiscard]] Result<bool> check_build() const {
        const RecordingHeader own = RecordingHeader::of_this_build();
        if (header.generation != own.generation) {
            return Result<bool>::failure(
                "the recording '" + name + "' comes from simulation generation " +
                std::to_string(header.generation) + ", this program has " +
                std::to_string(own.generation) + "; replay it with a build of its own time");
        }
        if (header.target != own.target) {
            return Result<bool>::failure("the recording '" + name +
                                         "' was made by a build for target '" + header.target +
                                         "', this one is for '" + own.target +
                                         "'; build with -DZONED_TARGET=" + header.target);
        }
        return true;
    }

    bool read_tick(TickRecord& record) const {
        const proto::RecordedTick& from = frame.tick();
        record.tick = from.tick();
        record.zones.resize(static_cast<std::size_t>(from.zones_size()));
        for (int z = 0; z < from.zones_size(); ++z) {
            ZoneTick& zone = record.zones[static_cast<std::size_t>(z)];
            const proto::RecordedZone& recorded = from.zones(z);
            if (recorded.zone() == 0 || recorded.zone() > 0xFFFF) {
                return false;
            }
            zone.zone = ZoneId(static_cast<std::uint16_t>(recorded.zone()));
            zone.hash = recorded.hash();
            zone.inbox.resize(static_cast<std::size_t>(recorded.items_size()));
            for (int i = 0; i < recorded.items_size(); ++i) {
                if (!from_record(recorded.items(i), zone.inbox[static_cast<std::size_t>(i)])) {
                    return false;
                }
            }
        }
        return true;
    }
};

RecordingReader::RecordingReader() : impl_(std::make_unique<Impl>()) {
}

RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;
RecordingReader::~RecordingReader() = default;

Result<bool> RecordingReader::open(const std::string& file) {
    impl_ = std::make_unique<Impl>();
    impl_->name = file;
    errno = 0;
    impl_->file.reset(std::fopen(file.c_str(), "rb"));
    if (!impl_->file || std::fseek(impl_->file.get(), 0, SEEK_END) != 0) {
        return Result<bool>::failure("cannot read the recording '" + file +
                                     "': " + system_reason());
    }
    const long size = std::ftell(impl_->file.get());
    std::rewind(impl_->file.get());
    impl_->size = size < 0 ? 0 : static_cast<std::uint64_t>(size);
    char magic[sizeof(kMagic)] = {};
    if (impl_->size < sizeof(kMagic) || !impl_->read(magic, sizeof(magic)) ||
        std::memcmp(magic, kMagic, sizeof(kMagic)) != 0) {
        return Result<bool>::failure("'" + file + "' is no recording of zoned");
    }
    impl_->at = sizeof(kMagic);
    return impl_->read_header();
}

const RecordingHeader& RecordingReader::header() const {
    return impl_->header;
}

Result<bool> RecordingReader::next(TickRecord& record) {
    if (!impl_->file) {
        return Result<bool>::failure("no recording is open");
    }
    if (impl_->ended) {
        return false;
    }
    const Result<bool> more = impl_->read_frame();
    if (!more.ok()) {
        return more;
    }
    if (!more.value()) {
        return impl_->damaged("ends without an end mark: the server did not come to close it");
    }
    if (impl_->frame.has_end()) {
        if (impl_->frame.end().ticks() != impl_->ticks) {
            return impl_->damaged("is corrupt: its end mark counts other ticks");
        }
        if (impl_->at != impl_->size) {
            return impl_->damaged("is corrupt: something follows its end mark");
        }
        impl_->ended = true;
        return false;
    }
    if (!impl_->frame.has_tick() || !impl_->read_tick(record)) {
        return impl_->damaged("is corrupt: a frame holds no valid tick");
    }
    if (impl_->ticks > 0 && record.tick <= impl_->last) {
        return impl_->damaged("is corrupt: ticks do not ascend");
    }
    impl_->last = record.tick;
    ++impl_->ticks;
    return true;
}

}  // namespace zoned::recording
