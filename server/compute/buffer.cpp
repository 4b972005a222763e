// Buffers: mapped where the device works in the host's memory, copied where it has its own.
#include "server/compute/device_impl.h"
#include "server/compute/host_block.h"

#include <array>
#include <cstring>
#include <utility>

namespace zoned::compute {

core::Result<Buffer> Buffer::over(Device& device, void* host, std::size_t bytes) {
    using Made = core::Result<Buffer>;
    if (device.lost()) {
        return Made::failure(device.fault());
    }
    Device::Impl& impl = *device.impl_;
    const auto refuse = [&](const std::string& why) {
        return Made::failure("OpenCL: a buffer of " + std::to_string(bytes) + " bytes on " +
                             to_text(impl.info) + ": " + why);
    };
    if (bytes == 0 || reinterpret_cast<std::uintptr_t>(host) % HostBlock::kPage != 0) {
        return refuse("it is empty or does not begin on a page");
    }
    if (bytes > impl.info.largest_buffer_bytes) {
        return refuse("it takes " + std::to_string(impl.info.largest_buffer_bytes) + " at most");
    }
    if (impl.testing != nullptr && impl.memory_bytes + bytes > impl.testing->memory_bytes) {
        return refuse("memory ran out on purpose");
    }
    const bool mapped = impl.buffers == BufferMode::kMapped;
    cl_int code = CL_SUCCESS;
    cl_mem handle = impl.cl->clCreateBuffer(
        impl.context,
        mapped ? CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR : CL_MEM_READ_WRITE,
        bytes,
        mapped ? host : nullptr,
        &code);
    if (code != CL_SUCCESS) {
        return refuse(opencl_error(code));
    }
    Buffer buffer;
    buffer.device_ = &device;
    buffer.handle_ = handle;
    buffer.host_ = host;
    buffer.bytes_ = bytes;
    impl.memory_bytes += bytes;
    if (!mapped) {
        if (const cl_int staging = buffer.make_staging(); staging != CL_SUCCESS) {
            return refuse("no memory of the host to copy through: " + opencl_error(staging));
        }
    } else if (!buffer.map() || !device.finish()) {
        return Made::failure(device.fault());
    }
    return buffer;
}

/// Memory that the driver keeps in place, so that the device reads and writes it by itself; other
/// memory it copies piece by piece.
cl_int Buffer::make_staging() {
    Device::Impl& impl = *device_->impl_;
    cl_int code = CL_SUCCESS;
    staging_handle_ = impl.cl->clCreateBuffer(
        impl.context, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, bytes_, nullptr, &code);
    if (code == CL_SUCCESS) {
        staging_ = impl.cl->clEnqueueMapBuffer(impl.queue,
                                               static_cast<cl_mem>(staging_handle_),
                                               CL_TRUE,
                                               CL_MAP_READ | CL_MAP_WRITE,
                                               0,
                                               bytes_,
                                               0,
                                               nullptr,
                                               nullptr,
                                               &code);
    }
    return code;
}

/// Queued, not waited for.
Status Buffer::map() {
    Device::Impl& impl = *device_->impl_;
    const cl_int code = impl.call([&] {
        cl_int mapped = CL_SUCCESS;
        impl.cl->clEnqueueMapBuffer(impl.queue,
                                    static_cast<cl_mem>(handle_),
                                    CL_FALSE,
                                    CL_MAP_READ | CL_MAP_WRITE,
                                    0,
                                    bytes_,
                                    0,
                                    nullptr,
                                    nullptr,
                                    &mapped);
        return mapped;
    });
    mapped_ = code == CL_SUCCESS;
    return mapped_ ? done() : device_->lose("mapping a buffer: " + opencl_error(code));
}

Status Buffer::unmap() {
    if (!mapped_) {
        return done();
    }
    Device::Impl& impl = *device_->impl_;
    // A mapped buffer lies where the host put it, as CL_MEM_USE_HOST_PTR says.
    const cl_int code = impl.call([&] {
        return impl.cl->clEnqueueUnmapMemObject(
            impl.queue, static_cast<cl_mem>(handle_), host_, 0, nullptr, nullptr);
    });
    mapped_ =
        code != CL_SUCCESS;  // then the destructor tries again, or the driver keeps the buffer
    return code == CL_SUCCESS ? done() : device_->lose("unmapping: " + opencl_error(code));
}

Buffer::Buffer(Buffer&& other) noexcept
    : device_(other.device_),
      handle_(std::exchange(other.handle_, nullptr)),
      host_(other.host_),
      staging_handle_(std::exchange(other.staging_handle_, nullptr)),
      staging_(std::exchange(other.staging_, nullptr)),
      bytes_(other.bytes_),
      coming_(other.coming_),
      mapped_(std::exchange(other.mapped_, false)) {
}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(handle_, other.handle_);
    std::swap(host_, other.host_);
    std::swap(staging_handle_, other.staging_handle_);
    std::swap(staging_, other.staging_);
    std::swap(bytes_, other.bytes_);
    std::swap(coming_, other.coming_);
    std::swap(mapped_, other.mapped_);
    return *this;
}

/// Needs no turn: the functions that it calls may be called from several threads at a time.
Buffer::~Buffer() {
    if (handle_ != nullptr) {
        Device::Impl& impl = *device_->impl_;
        if (mapped_) {
            impl.cl->clEnqueueUnmapMemObject(
                impl.queue, static_cast<cl_mem>(handle_), host_, 0, nullptr, nullptr);
        }
        if (staging_ != nullptr) {
            impl.cl->clEnqueueUnmapMemObject(
                impl.queue, static_cast<cl_mem>(staging_handle_), staging_, 0, nullptr, nullptr);
        }
        // A step that was broken off may have left a copy in the queue, from memory that goes next.
        impl.cl->clFinish(impl.queue);
        impl.cl->clReleaseMemObject(static_cast<cl_mem>(handle_));
        if (staging_handle_ != nullptr) {
            impl.cl->clReleaseMemObject(static_cast<cl_mem>(staging_handle_));
        }
        impl.memory_bytes -= bytes_;
    }
}

/// Calls visit(offset, bytes) for each row.
template <class Visit>
void Buffer::for_each_row(const Rows& rows, Visit&& visit) {
    for (std::size_t row = 0; row < rows.count; ++row) {
        visit(row * rows.pitch, rows.bytes);
    }
}

Status Buffer::give(const Rows& rows) {
    if (device_->lost()) {
        return Status::failure(device_->fault());
    }
    coming_ = Rows();
    Device::Impl& impl = *device_->impl_;
    if (impl.buffers == BufferMode::kMapped) {
        return unmap();
    }
    for_each_row(rows, [this](std::size_t offset, std::size_t bytes) {
        std::memcpy(
            static_cast<char*>(staging_) + offset, static_cast<const char*>(host_) + offset, bytes);
    });
    const cl_int code = transfer(impl.cl->clEnqueueWriteBufferRect, rows);
    return code == CL_SUCCESS ? done() : device_->lose("a copy to it: " + opencl_error(code));
}

Status Buffer::take(const Rows& rows) {
    if (device_->lost()) {
        return Status::failure(device_->fault());
    }
    Device::Impl& impl = *device_->impl_;
    if (impl.buffers == BufferMode::kMapped) {
        return mapped_ ? done() : map();
    }
    if (rows.bytes == 0) {
        return done();
    }
    const cl_int code = transfer(impl.cl->clEnqueueReadBufferRect, rows);
    if (code == CL_SUCCESS) {
        coming_ = rows;
    }
    return code == CL_SUCCESS ? done() : device_->lose("a copy from it: " + opencl_error(code));
}

/// Queues one copy of all rows between the device and the staging memory, which has the same shape.
template <class Copy>
int Buffer::transfer(Copy copy, const Rows& rows) {
    Device::Impl& impl = *device_->impl_;
    constexpr std::array<std::size_t, 3> kOrigin{};
    const std::array<std::size_t, 3> region{rows.bytes, rows.count, 1};
    return impl.call([&] {
        return copy(impl.queue,
                    static_cast<cl_mem>(handle_),
                    CL_FALSE,
                    kOrigin.data(),
                    kOrigin.data(),
                    region.data(),
                    rows.pitch,
                    0,
                    rows.pitch,
                    0,
                    staging_,
                    0,
                    nullptr,
                    nullptr);
    });
}

void Buffer::settle() {
    if (!device_->lost()) {
        for_each_row(coming_, [this](std::size_t offset, std::size_t bytes) {
            std::memcpy(static_cast<char*>(host_) + offset,
                        static_cast<const char*>(staging_) + offset,
                        bytes);
        });
    }
    coming_ = Rows();
}

}  // namespace zoned::compute
