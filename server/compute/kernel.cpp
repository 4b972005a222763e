// Kernels: arguments, work groups, launches.
#include "server/compute/device_impl.h"

#include <algorithm>
#include <utility>

namespace zoned::compute {

namespace {

constexpr std::size_t kCpuGroup = 1024;
constexpr std::size_t kGpuGroup = 256;

}  // namespace

std::size_t choose_group(const DeviceInfo& device, std::size_t limit, std::size_t multiple) {
    const std::size_t most = std::max<std::size_t>(1, std::min(limit, device.largest_group));
    const std::size_t wanted = device.kind == DeviceKind::kCpu ? kCpuGroup : kGpuGroup;
    if (wanted >= most) {
        return most;
    }
    const std::size_t step = std::max<std::size_t>(1, multiple);
    return std::clamp<std::size_t>(wanted / step * step, std::min(step, most), most);
}

core::Result<Kernel> Kernel::make(Device& device,
                                  std::string_view file,
                                  const std::string& function,
                                  const std::string& options) {
    using Made = core::Result<Kernel>;
    if (device.lost()) {
        return Made::failure(device.fault());
    }
    Device::Impl& impl = *device.impl_;
    const auto program = impl.program(file, options);
    if (!program) {
        return Made::failure(program.error());
    }
    cl_int code = CL_SUCCESS;
    cl_kernel handle = impl.cl->clCreateKernel(*program, function.c_str(), &code);
    if (code != CL_SUCCESS) {
        return Made::failure(std::string(file) + " has no kernel " + function + ": " +
                             opencl_error(code));
    }
    Kernel kernel;
    kernel.device_ = &device;
    kernel.handle_ = handle;
    std::size_t limit = impl.info.largest_group;
    std::size_t multiple = 1;
    const cl_device_id id = impl.device();
    impl.cl->clGetKernelWorkGroupInfo(
        handle, id, CL_KERNEL_WORK_GROUP_SIZE, sizeof(limit), &limit, nullptr);
    impl.cl->clGetKernelWorkGroupInfo(handle,
                                      id,
                                      CL_KERNEL_PREFERRED_WORK_GROUP_SIZE_MULTIPLE,
                                      sizeof(multiple),
                                      &multiple,
                                      nullptr);
    kernel.largest_group_ = std::max<std::size_t>(1, limit);
    kernel.group_ = choose_group(impl.info, limit, multiple);
    return kernel;
}

Kernel::Kernel(Kernel&& other) noexcept
    : device_(other.device_),
      handle_(std::exchange(other.handle_, nullptr)),
      group_(other.group_),
      largest_group_(other.largest_group_) {
}

Kernel& Kernel::operator=(Kernel&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(handle_, other.handle_);
    std::swap(group_, other.group_);
    std::swap(largest_group_, other.largest_group_);
    return *this;
}

Kernel::~Kernel() {
    if (handle_ != nullptr) {
        device_->impl_->cl->clReleaseKernel(static_cast<cl_kernel>(handle_));
    }
}

void Kernel::set_group(std::size_t items) {
    group_ = std::clamp<std::size_t>(items, 1, largest_group_);
}

Status Kernel::set_bytes(unsigned index, const void* value, std::size_t bytes) {
    if (device_->lost()) {
        return Status::failure(device_->fault());
    }
    Device::Impl& impl = *device_->impl_;
    const cl_int code = impl.call([&] {
        return impl.cl->clSetKernelArg(static_cast<cl_kernel>(handle_), index, bytes, value);
    });
    return code == CL_SUCCESS
               ? done()
               : device_->lose("argument " + std::to_string(index) + ": " + opencl_error(code));
}

Status Kernel::set(unsigned index, const Buffer& buffer) {
    const auto handle = static_cast<cl_mem>(buffer.handle_);
    return set_bytes(index, &handle, sizeof(handle));
}

Status Kernel::set_local(unsigned index, std::size_t bytes) {
    return set_bytes(index, nullptr, bytes);
}

Status Kernel::launch(std::size_t count) {
    if (device_->lost()) {
        return Status::failure(device_->fault());
    }
    Device::Impl& impl = *device_->impl_;
    const std::size_t groups = groups_of(count);
    if (impl.testing != nullptr && impl.testing->launches >= 0 &&
        impl.launches >= impl.testing->launches) {
        const auto run =
            static_cast<std::size_t>(impl.testing->share_run * static_cast<double>(groups));
        if (run > 0 && launch_groups(run)) {
            impl.cl->clFinish(impl.queue);
        }
        return device_->lose("a launch failed on purpose: " + opencl_error(CL_OUT_OF_RESOURCES));
    }
    ++impl.launches;
    return launch_groups(groups);
}

Status Kernel::launch_groups(std::size_t groups) {
    Device::Impl& impl = *device_->impl_;
    const std::size_t items = groups * group_;
    const cl_int code = impl.call([&] {
        return impl.cl->clEnqueueNDRangeKernel(impl.queue,
                                               static_cast<cl_kernel>(handle_),
                                               1,
                                               nullptr,
                                               &items,
                                               &group_,
                                               0,
                                               nullptr,
                                               nullptr);
    });
    return code == CL_SUCCESS ? done() : device_->lose("a launch: " + opencl_error(code));
}

}  // namespace zoned::compute
