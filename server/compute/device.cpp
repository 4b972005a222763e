#include "server/compute/device.h"

#include "server/compute/device_impl.h"

#include <utility>

namespace zoned::compute {

Device::Device(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {
}

Device::~Device() {
    const OpenClApi& cl = *impl_->cl;
    for (const auto& [key, program] : impl_->programs) {
        cl.clReleaseProgram(program);
    }
    if (impl_->queue != nullptr) {
        cl.clReleaseCommandQueue(impl_->queue);
    }
    if (impl_->context != nullptr) {
        cl.clReleaseContext(impl_->context);
    }
}

core::Result<std::unique_ptr<Device>> Device::open(const DeviceSettings& settings) {
    using Opened = core::Result<std::unique_ptr<Device>>;
    if (settings.wish == "none") {
        return Opened::failure(choose_device({}, settings.wish).reason);  // and nothing is loaded
    }
    const auto devices = list_devices();
    if (!devices) {
        return Opened::failure(devices.error());
    }
    DeviceChoice choice = choose_device(*devices, settings.wish);
    if (!choice.index) {
        return Opened::failure(std::move(choice.reason));
    }
    auto impl = std::make_unique<Impl>();
    impl->cl = &*opencl_api();
    impl->info = (*devices)[*choice.index];
    impl->reason = std::move(choice.reason);
    impl->buffers = settings.buffers;
    if (settings.buffers == BufferMode::kAuto) {
        // A CPU ends each work group that it began, so that after a fault it is known which columns
        // have changed. A GPU that is reset in a step leaves some groups half done, even where it
        // shares the host's memory.
        const bool in_place = impl->info.host_memory && impl->info.kind == DeviceKind::kCpu;
        impl->buffers = in_place ? BufferMode::kMapped : BufferMode::kCopied;
    }
    impl->kernels = settings.kernels;
    impl->testing = settings.testing;
    impl->cache = ProgramCache(settings.cache_folder);
    std::unique_ptr<Device> device(new Device(std::move(impl)));
    Impl& made = *device->impl_;
    const cl_context_properties properties[] = {
        CL_CONTEXT_PLATFORM, reinterpret_cast<cl_context_properties>(made.info.platform_handle), 0};
    const cl_device_id id = made.device();
    cl_int code = CL_SUCCESS;
    made.context = made.cl->clCreateContext(properties, 1, &id, nullptr, nullptr, &code);
    if (code == CL_SUCCESS) {
        made.queue = made.cl->clCreateCommandQueue(made.context, id, 0, &code);
    }
    if (code != CL_SUCCESS) {
        return Opened::failure("OpenCL: " + to_text(made.info) +
                               " does not open: " + opencl_error(code));
    }
    return device;
}

const DeviceInfo& Device::info() const {
    return impl_->info;
}

const std::string& Device::reason() const {
    return impl_->reason;
}

BufferMode Device::buffers() const {
    return impl_->buffers;
}

bool Device::lost() const {
    return !impl_->fault.empty();
}

const std::string& Device::fault() const {
    return impl_->fault;
}

std::mutex& Device::turn() {
    return impl_->turn;
}

ProgramCounts Device::programs() const {
    return impl_->counts;
}

Status Device::finish() {
    if (lost()) {
        return Status::failure(fault());
    }
    const cl_int code = impl_->call([&] { return impl_->cl->clFinish(impl_->queue); });
    return code == CL_SUCCESS ? done() : lose("waiting for it: " + opencl_error(code));
}

Status Device::lose(std::string why) {
    if (!lost()) {
        impl_->fault = "OpenCL: lost " + to_text(impl_->info) + ": " + std::move(why);
        // Work that was queued before may still run, and write into memory that the CPU is about to
        // use.
        impl_->cl->clFinish(impl_->queue);
    }
    return Status::failure(fault());
}

}  // namespace zoned::compute
