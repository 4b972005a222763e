#include "server/compute/device_list.h"

#include "server/compute/opencl_api.h"

#include <algorithm>
#include <cctype>

namespace zoned::compute {

namespace {

std::string device_text(const OpenClApi& cl, cl_device_id device, cl_device_info what) {
    std::size_t size = 0;
    if (cl.clGetDeviceInfo(device, what, 0, nullptr, &size) != CL_SUCCESS || size == 0) {
        return {};
    }
    std::string text(size, '\0');
    if (cl.clGetDeviceInfo(device, what, size, text.data(), nullptr) != CL_SUCCESS) {
        return {};
    }
    text.resize(std::min(text.find('\0'), text.size()));  // OpenCL counts the terminator
    return text;
}

std::string platform_name(const OpenClApi& cl, cl_platform_id platform) {
    char text[256] = {};
    if (cl.clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof(text) - 1, text, nullptr) !=
        CL_SUCCESS) {
        return {};
    }
    return text;
}

template <class T>
T device_value(const OpenClApi& cl, cl_device_id device, cl_device_info what) {
    T value{};
    cl.clGetDeviceInfo(device, what, sizeof(value), &value, nullptr);
    return value;
}

DeviceKind kind_of(cl_device_type type) {
    if ((type & CL_DEVICE_TYPE_GPU) != 0) {
        return DeviceKind::kGpu;
    }
    return (type & CL_DEVICE_TYPE_CPU) != 0 ? DeviceKind::kCpu : DeviceKind::kOther;
}

DeviceInfo describe(const OpenClApi& cl, cl_platform_id platform, cl_device_id device) {
    DeviceInfo info;
    info.name = device_text(cl, device, CL_DEVICE_NAME);
    info.platform = platform_name(cl, platform);
    info.driver = device_text(cl, device, CL_DRIVER_VERSION);
    info.kind = kind_of(device_value<cl_device_type>(cl, device, CL_DEVICE_TYPE));
    info.compute_units = device_value<cl_uint>(cl, device, CL_DEVICE_MAX_COMPUTE_UNITS);
    info.memory_bytes = device_value<cl_ulong>(cl, device, CL_DEVICE_GLOBAL_MEM_SIZE);
    info.largest_buffer_bytes = device_value<cl_ulong>(cl, device, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
    info.largest_group = device_value<std::size_t>(cl, device, CL_DEVICE_MAX_WORK_GROUP_SIZE);
    info.local_bytes = device_value<cl_ulong>(cl, device, CL_DEVICE_LOCAL_MEM_SIZE);
    info.own_local_memory =
        device_value<cl_device_local_mem_type>(cl, device, CL_DEVICE_LOCAL_MEM_TYPE) == CL_LOCAL;
    info.host_memory = device_value<cl_bool>(cl, device, CL_DEVICE_HOST_UNIFIED_MEMORY) != 0;
    const auto rounding = device_value<cl_device_fp_config>(cl, device, CL_DEVICE_SINGLE_FP_CONFIG);
    info.correctly_rounded = (rounding & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
    info.available = device_value<cl_bool>(cl, device, CL_DEVICE_AVAILABLE) != 0 &&
                     device_value<cl_bool>(cl, device, CL_DEVICE_COMPILER_AVAILABLE) != 0;
    info.handle = device;
    info.platform_handle = platform;
    return info;
}

std::string lower(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) {
        return static_cast<char>(std::tolower(c));
    });
    return out;
}

int rank_of(DeviceKind kind) {
    return kind == DeviceKind::kGpu ? 2 : kind == DeviceKind::kCpu ? 1 : 0;
}

bool better(const DeviceInfo& a, const DeviceInfo& b) {
    if (a.kind != b.kind) {
        return rank_of(a.kind) > rank_of(b.kind);
    }
    return a.compute_units > b.compute_units;
}

bool wished_for(const DeviceInfo& device, const std::string& wish) {
    if (wish.empty() || wish == "auto") {
        return true;
    }
    if (wish == "cpu" || wish == "gpu") {
        return name_of(device.kind) == wish;
    }
    return lower(device.name).find(wish) != std::string::npos;
}

/// Why a device is not taken; empty: it may be.
std::string unfit(const DeviceInfo& device) {
    if (!device.available) {
        return "it is not available or has no compiler";
    }
    return device.correctly_rounded ? std::string() : "it does not round division and square root";
}

}  // namespace

std::string_view name_of(DeviceKind kind) {
    switch (kind) {
        case DeviceKind::kCpu:
            return "cpu";
        case DeviceKind::kGpu:
            return "gpu";
        case DeviceKind::kOther:
            break;
    }
    return "other";
}

core::Result<std::vector<DeviceInfo>> list_devices() {
    using Listed = core::Result<std::vector<DeviceInfo>>;
    const core::Result<OpenClApi>& opened = opencl_api();
    if (!opened) {
        return Listed::failure(opened.error());
    }
    const OpenClApi& cl = *opened;
    cl_uint count = 0;
    const cl_int code = cl.clGetPlatformIDs(0, nullptr, &count);
    if (code != CL_SUCCESS || count == 0) {
        return Listed::failure("OpenCL: no platform: " + opencl_error(code));
    }
    std::vector<cl_platform_id> platforms(count);
    cl.clGetPlatformIDs(count, platforms.data(), nullptr);
    std::vector<DeviceInfo> devices;
    for (const cl_platform_id platform : platforms) {
        cl_uint n = 0;
        if (cl.clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &n) != CL_SUCCESS) {
            continue;  // CL_DEVICE_NOT_FOUND: a platform without devices
        }
        std::vector<cl_device_id> ids(n);
        cl.clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, n, ids.data(), nullptr);
        for (const cl_device_id id : ids) {
            devices.push_back(describe(cl, platform, id));
        }
    }
    return devices;
}

DeviceChoice choose_device(std::span<const DeviceInfo> devices, std::string_view wish) {
    const std::string wanted = lower(wish);
    if (wanted == "none") {
        return {std::nullopt, "the setting is \"none\""};
    }
    DeviceChoice choice;
    std::string refused;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        if (!wished_for(devices[i], wanted)) {
            continue;
        }
        const std::string why_not = unfit(devices[i]);
        if (!why_not.empty()) {
            refused += "; " + devices[i].name + ": " + why_not;
        } else if (!choice.index || better(devices[i], devices[*choice.index])) {
            choice.index = i;
        }
    }
    const std::string asked = wanted.empty() ? "auto" : std::string(wish);
    if (choice.index) {
        choice.reason = "\"" + asked + "\" among " + std::to_string(devices.size()) + ": " +
                        to_text(devices[*choice.index]) + refused;
    } else {
        choice.reason = "none of " + std::to_string(devices.size()) + " devices fits \"" + asked +
                        "\"" + refused;
    }
    return choice;
}

std::string to_text(const DeviceInfo& device) {
    return std::string(name_of(device.kind)) + " " + device.name + " (" + device.platform +
           ", driver " + device.driver + "), " + std::to_string(device.compute_units) +
           " compute units, " + std::to_string(device.memory_bytes >> 20U) + " MiB";
}

}  // namespace zoned::compute
