// A Vulkan layer that rewrites every compute shader as WGSL allows a driver to: products and sums are fused, sums and products are
// reassociated, divisions and square roots are off by two units in the last place more than a rounded one. A hash of HOSTILE_SEED, the
// module and the instruction chooses each, so kernels that compute one expression twice may round it differently.
//
//   HOSTILE_SEED=n      HOSTILE_FUSE, HOSTILE_ORDER, HOSTILE_ROUND: the percentage of sums, of chains, of divisions and roots
//   HOSTILE_LOG=file    gets one line for each module
//   HOSTILE_MODULE=n    rewrites the nth module alone, to find the one that a fault depends on
//   HOSTILE_LOSE=n      the nth submission of an instance loses its device
//   HOSTILE_EXHAUST=n   there is no memory for the nth allocation of an instance; with HOSTILE_EXHAUST_FROM=n for none from the nth on
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

static PFN_vkGetInstanceProcAddr next_instance;
static PFN_vkGetDeviceProcAddr next_device;
// The same of every device, since one driver made them: a device may end while others submit.
static PFN_vkQueueSubmit next_submit;

static uint32_t number(const char *name, uint32_t usual) {
    const char *text = getenv(name);
    return text && *text ? (uint32_t)strtoul(text, 0, 10) : usual;
}

static uint32_t mix(uint32_t h) {
    h ^= h >> 16, h *= 0x7feb352du, h ^= h >> 15, h *= 0x846ca68bu, h ^= h >> 16;
    return h;
}

typedef struct { uint32_t *w; size_t n, room; } Words;
static void put(Words *o, uint32_t x) {
    if (o->n == o->room) o->w = realloc(o->w, sizeof(uint32_t) * (o->room = 2 * o->room + 1024));
    o->w[o->n++] = x;
}
static void op(Words *o, uint32_t code, uint32_t n, const uint32_t *args) {
    put(o, code | (n + 1) << 16);
    for (uint32_t i = 0; i < n; i++) put(o, args[i]);
}
#define OP(o, code, ...) op(o, code, sizeof((uint32_t[]){__VA_ARGS__}) / 4, (uint32_t[]){__VA_ARGS__})

enum { CAPABILITY = 17, EXT_IMPORT = 11, EXT_INST = 12, TYPE_FLOAT = 22, TYPE_VECTOR = 23, CONSTANT = 43, FUNCTION = 54, FCONVERT = 115,
    FADD = 129, FSUB = 131, FMUL = 133, FDIV = 136, TIMES_SCALAR = 142, DOT = 148, SQRT = 31, INVERSE_SQRT = 32 };

typedef struct { uint32_t code, type, a, b; } Def;

static uint32_t fused, ordered, rounded, modules;

static uint32_t *rewrite(const uint32_t *in, size_t count, size_t *made) {
    uint32_t seed = number("HOSTILE_SEED", 1), fuse = number("HOSTILE_FUSE", 100), order = number("HOSTILE_ORDER", 0);
    uint32_t round = number("HOSTILE_ROUND", 0), hash = mix(seed), bound = in[3];
    if (number("HOSTILE_MODULE", modules + 1) != modules + 1) fuse = order = round = 0;
    for (size_t i = 5; i < count; i++) hash = mix(hash ^ in[i]);
    Def *defs = calloc(bound, sizeof(Def));
    uint32_t *lanes = calloc(bound, 4); // of a type of f32: 1 to 4
    uint32_t *is_type = calloc(bound, 4);
    uint32_t f32 = 0, f64 = 0, wides[5] = {0}, glsl = 0, has64 = 0;
    size_t body = count, after_capabilities = 5;
    for (size_t i = 5; i < count; i += in[i] >> 16) {
        uint32_t code = in[i] & 0xffff;
        const uint32_t *a = in + i + 1;
        if (code == CAPABILITY) after_capabilities = i + 2, has64 |= a[0] == 10;
        if (code == EXT_IMPORT) glsl = a[0];
        if (code == TYPE_FLOAT && a[1] == 32) f32 = a[0], lanes[f32] = 1;
        if (code == TYPE_FLOAT && a[1] == 64) f64 = a[0], wides[1] = f64;
        if (code == TYPE_VECTOR && f32 && a[1] == f32) lanes[a[0]] = a[2];
        if (code == TYPE_VECTOR && f64 && a[1] == f64) wides[a[2]] = a[0];
        if (code >= 19 && code <= 39) is_type[a[0]] = 1;
        if (code == FUNCTION && body == count) body = i;
    }
    Words out = {0}, types = {0}, code_of = {0};
    uint32_t next = bound;
    if (!f64) { f64 = wides[1] = next++; OP(&types, TYPE_FLOAT, f64, 64); }
    for (uint32_t n = 2; n < 5; n++) if (!wides[n]) { wides[n] = next++; OP(&types, TYPE_VECTOR, wides[n], f64, n); }
    #define CHOSEN(percent) (mix(hash ^ (uint32_t)(i * 2654435761u)) % 100 < (percent))
    uint32_t before[3] = {fused, ordered, rounded};
    for (size_t i = body; i < count; i += in[i] >> 16) {
        uint32_t code = in[i] & 0xffff, length = in[i] >> 16;
        const uint32_t *a = in + i + 1;
        uint32_t type = length > 2 && a[0] < bound && is_type[a[0]] ? a[0] : 0, n = type ? lanes[type] : 0, w = n ? wides[n] : 0;
        int copied = 0;
        if (n && (code == FADD || code == FSUB)) {
            uint32_t which = 0;
            for (uint32_t k = 0; k < 2; k++) {
                uint32_t c = defs[a[2 + k]].code;
                if ((c == FMUL || c == TIMES_SCALAR) && (!which || mix(hash ^ (uint32_t)i) & 1)) which = k + 1;
            }
            if (which && CHOSEN(fuse)) {
                Def m = defs[a[1 + which]];
                uint32_t other = a[4 - which], x = next++, y = next++, p = next++, c = next++, s = next++;
                OP(&code_of, FCONVERT, w, x, m.a);
                OP(&code_of, FCONVERT, m.code == FMUL ? w : f64, y, m.b);
                OP(&code_of, m.code, w, p, x, y);
                OP(&code_of, FCONVERT, w, c, other);
                OP(&code_of, code, w, s, which == 1 ? p : c, which == 1 ? c : p);
                OP(&code_of, FCONVERT, type, a[1], s);
                fused++, copied = 1;
            } else if (code == FADD && (defs[a[2]].code == FADD) && CHOSEN(order)) {
                Def m = defs[a[2]]; // (a + b) + c = a + (b + c)
                uint32_t x = next++;
                OP(&code_of, FADD, type, x, m.b, a[3]);
                OP(&code_of, FADD, type, a[1], m.a, x);
                ordered++, copied = 1;
            }
        } else if (n && code == FMUL && defs[a[2]].code == FMUL && CHOSEN(order)) {
            Def m = defs[a[2]];
            uint32_t x = next++;
            OP(&code_of, FMUL, type, x, m.b, a[3]);
            OP(&code_of, FMUL, type, a[1], m.a, x);
            ordered++, copied = 1;
        } else if (n == 1 && code == DOT && CHOSEN(fuse)) {
            uint32_t of = defs[a[2]].type;
            if (of && lanes[of] > 1) {
                uint32_t v = wides[lanes[of]], x = next++, y = next++, s = next++;
                OP(&code_of, FCONVERT, v, x, a[2]);
                OP(&code_of, FCONVERT, v, y, a[3]);
                OP(&code_of, DOT, f64, s, x, y);
                OP(&code_of, FCONVERT, type, a[1], s);
                fused++, copied = 1;
            }
        } else if (n && (code == FDIV || (code == EXT_INST && a[2] == glsl && (a[3] == SQRT || a[3] == INVERSE_SQRT))) && CHOSEN(round)) {
            // Times 1 +- 2 u, before the last rounding.
            union { double d; uint32_t w[2]; } factor;
            factor.d = 1.0 + (mix(hash ^ (uint32_t)(i + 77)) & 1 ? 1.99 : -1.99) * 5.9604644775390625e-8;
            uint32_t k = next++, x = next++, y = next++;
            OP(&types, CONSTANT, f64, k, factor.w[0], factor.w[1]);
            uint32_t q = next++;
            if (code == FDIV) OP(&code_of, FDIV, type, q, a[2], a[3]);
            else OP(&code_of, EXT_INST, type, q, a[2], a[3], a[4]);
            // A quotient that is rounded once has half an ulp of error; 2 u at most are two more.
            OP(&code_of, FCONVERT, w, x, q);
            OP(&code_of, n == 1 ? FMUL : TIMES_SCALAR, w, y, x, k);
            OP(&code_of, FCONVERT, type, a[1], y);
            rounded++, copied = 1;
        }
        if (!copied) for (uint32_t j = 0; j < length; j++) put(&code_of, in[i + j]);
        // What is defined. Types of other values, for dot.
        if (type && length > 2 && a[1] < bound) {
            defs[a[1]] = (Def){0, type, 0, 0};
            if (n && (code == FMUL || code == FADD || code == TIMES_SCALAR)) defs[a[1]] = (Def){code, type, a[2], a[3]};
        }
    }
    for (size_t i = 0; i < after_capabilities; i++) put(&out, in[i]);
    if (!has64) OP(&out, CAPABILITY, 10);
    for (size_t i = after_capabilities; i < body; i++) put(&out, in[i]);
    for (size_t i = 0; i < types.n; i++) put(&out, types.w[i]);
    for (size_t i = 0; i < code_of.n; i++) put(&out, code_of.w[i]);
    out.w[3] = next;
    modules++;
    const char *log = getenv("HOSTILE_LOG");
    if (log) {
        FILE *f = fopen(log, "a");
        if (f) {
            fprintf(f, "module %u: %zu words, fused %u, reordered %u, rounded %u\n", modules, count, fused - before[0], ordered - before[1],
                rounded - before[2]);
            fclose(f);
        }
    }
    free(defs), free(lanes), free(is_type), free(types.w), free(code_of.w);
    *made = out.n;
    return out.w;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_module(VkDevice device, const VkShaderModuleCreateInfo *info, const VkAllocationCallbacks *a, VkShaderModule *m) {
    PFN_vkCreateShaderModule next = (PFN_vkCreateShaderModule)next_device(device, "vkCreateShaderModule");
    size_t n;
    uint32_t *words = rewrite(info->pCode, info->codeSize / 4, &n);
    VkShaderModuleCreateInfo own = *info;
    own.pCode = words, own.codeSize = 4 * n;
    VkResult result = next(device, &own, a, m);
    free(words);
    return result;
}

static uint32_t submissions, allocations;
static int is_lost;

static VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, uint32_t count, const VkSubmitInfo *infos, VkFence fence) {
    if (++submissions == number("HOSTILE_LOSE", 0)) is_lost = 1;
    return is_lost ? VK_ERROR_DEVICE_LOST : next_submit(queue, count, infos, fence);
}

static VKAPI_ATTR VkResult VKAPI_CALL allocate(VkDevice device, const VkMemoryAllocateInfo *info, const VkAllocationCallbacks *a, VkDeviceMemory *memory) {
    if (++allocations == number("HOSTILE_EXHAUST", 0) || allocations >= number("HOSTILE_EXHAUST_FROM", ~0u)) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    return ((PFN_vkAllocateMemory)next_device(device, "vkAllocateMemory"))(device, info, a, memory);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo *info, const VkAllocationCallbacks *a, VkInstance *instance) {
    VkLayerInstanceCreateInfo *link = (VkLayerInstanceCreateInfo *)info->pNext;
    while (link && !(link->sType == VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO && link->function == VK_LAYER_LINK_INFO))
        link = (VkLayerInstanceCreateInfo *)link->pNext;
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    next_instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)next_instance(0, "vkCreateInstance");
    return create(info, a, instance);
}

static VkInstance last_instance;
static VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice gpu, const VkDeviceCreateInfo *info, const VkAllocationCallbacks *a, VkDevice *device) {
    VkLayerDeviceCreateInfo *link = (VkLayerDeviceCreateInfo *)info->pNext;
    while (link && !(link->sType == VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO && link->function == VK_LAYER_LINK_INFO))
        link = (VkLayerDeviceCreateInfo *)link->pNext;
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    PFN_vkGetInstanceProcAddr instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    next_device = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    PFN_vkCreateDevice create = (PFN_vkCreateDevice)instance(last_instance, "vkCreateDevice");
    VkResult result = create(gpu, info, a, device);
    if (result == VK_SUCCESS) next_submit = (PFN_vkQueueSubmit)next_device(*device, "vkQueueSubmit"), is_lost = 0;
    return result;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_proc(VkDevice device, const char *name);
static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_proc(VkInstance instance, const char *name);
static PFN_vkVoidFunction own(const char *name) {
    if (!strcmp(name, "vkCreateShaderModule")) return (PFN_vkVoidFunction)create_module;
    if (!strcmp(name, "vkQueueSubmit")) return (PFN_vkVoidFunction)submit;
    if (!strcmp(name, "vkAllocateMemory")) return (PFN_vkVoidFunction)allocate;
    if (!strcmp(name, "vkGetDeviceProcAddr")) return (PFN_vkVoidFunction)device_proc;
    return 0;
}
static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_proc(VkDevice device, const char *name) {
    PFN_vkVoidFunction f = own(name);
    return f ? f : next_device(device, name);
}
static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_proc(VkInstance instance, const char *name) {
    if (!strcmp(name, "vkCreateInstance")) return (PFN_vkVoidFunction)create_instance;
    if (!strcmp(name, "vkGetInstanceProcAddr")) return (PFN_vkVoidFunction)instance_proc;
    if (instance) last_instance = instance;
    if (!strcmp(name, "vkCreateDevice")) return (PFN_vkVoidFunction)create_device;
    PFN_vkVoidFunction f = own(name);
    return f ? f : next_instance(instance, name);
}

VK_LAYER_EXPORT VKAPI_ATTR VkResult VKAPI_CALL vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *v) {
    if (v->loaderLayerInterfaceVersion > 2) v->loaderLayerInterfaceVersion = 2;
    v->pfnGetInstanceProcAddr = instance_proc;
    v->pfnGetDeviceProcAddr = device_proc;
    v->pfnGetPhysicalDeviceProcAddr = 0;
    return VK_SUCCESS;
}
