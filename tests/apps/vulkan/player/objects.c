#include "player.h"

#include "../../common/matrix.h"

#include <string.h>

world it;


#define OF_COLOR \
    (VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | \
     VK_IMAGE_USAGE_TRANSFER_DST_BIT)
#define OF_DEPTH \
    (VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | \
     VK_IMAGE_USAGE_TRANSFER_DST_BIT)
#define COLOR VK_IMAGE_ASPECT_COLOR_BIT
#define DEPTH VK_IMAGE_ASPECT_DEPTH_BIT
#define STENCIL VK_IMAGE_ASPECT_STENCIL_BIT

/* Kinds of images. Some are as large as the window. */
static const image_kind kinds[] = {
    {VK_FORMAT_B8G8R8A8_UNORM, 64, 48, 1, 1, COLOR, OF_COLOR, 4},
    {VK_FORMAT_R8G8B8A8_UNORM, 64, 48, 1, 1, COLOR, OF_COLOR | VK_IMAGE_USAGE_STORAGE_BIT, 4},
    {VK_FORMAT_D32_SFLOAT, 64, 48, 1, 1, DEPTH, OF_DEPTH, 4},
    {VK_FORMAT_B8G8R8A8_UNORM, 64, 48, 1, 4, COLOR, OF_COLOR, 4},
    {VK_FORMAT_D32_SFLOAT, 64, 48, 1, 4, DEPTH, OF_DEPTH, 4},
    {VK_FORMAT_R8G8B8A8_UNORM, 32, 32, 3, 1, COLOR, OF_COLOR | VK_IMAGE_USAGE_STORAGE_BIT, 4},
    {VK_FORMAT_R16G16B16A16_SFLOAT, 64, 48, 1, 1, COLOR, OF_COLOR, 8},
    {VK_FORMAT_D32_SFLOAT_S8_UINT, 64, 48, 1, 1, DEPTH | STENCIL, OF_DEPTH, 4},
    {VK_FORMAT_R8G8B8A8_SRGB, 32, 24, 1, 1, COLOR, OF_COLOR, 4},
    {VK_FORMAT_B8G8R8A8_UNORM, 80, 60, 2, 1, COLOR, OF_COLOR, 4},
};
enum { KINDS = sizeof kinds / sizeof kinds[0] };

slot_image *image_at(int number)
{
    return &it.images[number % (SLOTS + 1)];
}

bool is_color(const slot_image *image)
{
    return image->kind->aspects == COLOR;
}

static VkImageView view_of(VkImage image, const image_kind *kind, VkImageAspectFlags aspects, uint32_t levels)
{
    const VkImageViewCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                        .image = image,
                                        .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                        .format = kind->format,
                                        .subresourceRange = {aspects, 0, levels, 0, 1}};
    VkImageView view;
    expect(vkCreateImageView(it.w.device, &info, NULL, &view), "vkCreateImageView");
    return view;
}

static void image_create(slot_image *image, const image_kind *kind)
{
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = kind->format,
                                    .extent = {kind->width, kind->height, 1},
                                    .mipLevels = kind->levels,
                                    .arrayLayers = 1,
                                    .samples = kind->samples,
                                    .usage = kind->usage};
    image->kind = kind;
    expect(vkCreateImage(it.w.device, &info, NULL, &image->image), "vkCreateImage");
    image->memory = image_memory(&it.w, image->image);
    image->view = view_of(image->image, kind, kind->aspects, 1);
    image->sampled = view_of(image->image, kind, kind->aspects & ~(VkImageAspectFlags)STENCIL, kind->levels);
    own_commands_begin();
    image_layout(it.own, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    const VkImageSubresourceRange all = {kind->aspects, 0, VK_REMAINING_MIP_LEVELS, 0, 1};
    const VkClearColorValue color = {{0.25f, 0.5f, 0.75f, 1.0f}};
    const VkClearDepthStencilValue depth = {0.75f, 3};
    if (is_color(image))
        vkCmdClearColorImage(it.own, image->image, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &all);
    else
        vkCmdClearDepthStencilImage(it.own, image->image, VK_IMAGE_LAYOUT_GENERAL, &depth, 1, &all);
    own_commands_end();
}

static void image_free(slot_image *image)
{
    vkDestroyImageView(it.w.device, image->sampled, NULL);
    vkDestroyImageView(it.w.device, image->view, NULL);
    vkDestroyImage(it.w.device, image->image, NULL);
    vkFreeMemory(it.w.device, image->memory, NULL);
}

void image_make(int slot, int kind)
{
    submit(false);
    it.now.is_valid = false;
    image_free(&it.images[slot]);
    image_create(&it.images[slot], &kinds[kind % KINDS]);
    for (int set = 0; set < SETS; set++)
        if (it.set_image[set] == slot || it.set_result[set] == slot)
            set_write(set, it.set_image[set], 0, it.set_result[set]);
}

void set_write(int set, int number, int sampler, int result_number)
{
    number = it.images[number].kind->samples == VK_SAMPLE_COUNT_1_BIT ? number : DUMMY;
    result_number = (it.images[result_number].kind->usage & VK_IMAGE_USAGE_STORAGE_BIT) != 0 ? result_number : DUMMY;
    const slot_image *image = &it.images[number];
    const VkDescriptorBufferInfo camera = {it.buffers[set % 2].buffer, 0, 64},
                                 numbers = {it.buffers[2 + set % 2].buffer, 0, 1024};
    const VkDescriptorImageInfo sampled = {it.samplers[is_color(image) ? sampler % 2 : 0], image->sampled,
                                           VK_IMAGE_LAYOUT_GENERAL},
                                result = {VK_NULL_HANDLE, it.images[result_number].view, VK_IMAGE_LAYOUT_GENERAL};
    VkWriteDescriptorSet writes[] = {
        {.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, .pBufferInfo = &camera},
        {.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, .pImageInfo = &sampled},
        {.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .pBufferInfo = &numbers},
        {.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, .pImageInfo = &result},
    };
    const uint32_t count = sizeof writes / sizeof writes[0];
    for (uint32_t i = 0; i < count; i++) {
        writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        writes[i].dstSet = it.sets[set];
        writes[i].dstBinding = i;
        writes[i].descriptorCount = 1;
    }
    it.set_image[set] = number;
    it.set_result[set] = result_number;
    vkUpdateDescriptorSets(it.w.device, count, writes, 0, NULL);
}

/* Writes a matrix: cameras near and inside the cube, turned, with two lenses, and flat ones. */
void matrix_write(void *to, int kind)
{
    const matrix4 wide = matrix_perspective(90, 64.0 / 48, 0.1, 10), narrow = matrix_perspective(50, 64.0 / 48, 0.1, 10);
    matrix4 m;
    switch (kind % 6) {
    case 0:
        m = matrix_multiply(wide, matrix_camera(20, 10));
        break;
    case 1:
        m = matrix_multiply(wide, matrix_multiply(matrix_camera(-30, 0), matrix_translate(0.5, 0, -3)));
        break;
    case 2:
        m = matrix_multiply(narrow, matrix_translate(0, 0.5, -4));
        break;
    case 3:
        m = matrix_scale(0.5);
        break;
    case 4:
        m = matrix_multiply(matrix_translate(0.25, -0.25, 0.5), matrix_scale(0.25));
        break;
    default:
        m = matrix_multiply(wide, matrix_translate(0.25, 0, -2));
    }
    memcpy(to, m.m, sizeof m.m);
}

static void buffers_open(void)
{
    const VkBufferUsageFlags all = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                   VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                   VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
    for (int i = 0; i < BUFFERS; i++) {
        it.buffers[i] = make_block(&it.w, BUFFER_SIZE, all, true);
        unsigned char *bytes = it.buffers[i].bytes;
        memset(bytes, 0, BUFFER_SIZE);
        for (int at = 0; at < VERTICES; at += MATRIX_STEP)
            matrix_write(bytes + at, at / MATRIX_STEP + i);
        float *places = (float *)(void *)(bytes + VERTICES);
        for (int at = 0; at < (BUFFER_SIZE - VERTICES) / 4; at++)
            places[at] = (float)((at * 37 + i * 11) % 33 - 16) / 16.0f;
    }
    it.indices = make_block(&it.w, 4096, VK_BUFFER_USAGE_INDEX_BUFFER_BIT, true);
    for (int i = 0; i < 512; i++)
        ((uint16_t *)it.indices.bytes)[i] = (uint16_t)(i * 7 % CUBE);
    for (int i = 256; i < 1024; i++)
        ((uint32_t *)it.indices.bytes)[i] = (uint32_t)(i * 5 % CUBE);
    it.indirect = make_block(&it.w, 4096, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, true);
    uint32_t *numbers = it.indirect.bytes;
    for (uint32_t i = 0; i < 64; i++) {
        const uint32_t some[] = {3 * (i % 12), 1 + i % 2, 0, 0, 0};
        memcpy(numbers + 8 * i, some, sizeof some);
    }
    it.read = make_block(&it.w, READ_SIZE, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
}

static void descriptors_open(void)
{
    const VkShaderStageFlags all = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
    const VkDescriptorType types[] = {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                      VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE};
    VkDescriptorSetLayoutBinding bindings[4];
    VkDescriptorPoolSize sizes[4];
    for (uint32_t i = 0; i < 4; i++) {
        bindings[i] = (VkDescriptorSetLayoutBinding){
            .binding = i, .descriptorType = types[i], .descriptorCount = 1, .stageFlags = i < 2 ? all : VK_SHADER_STAGE_COMPUTE_BIT};
        sizes[i] = (VkDescriptorPoolSize){types[i], SETS};
    }
    const VkDescriptorSetLayoutCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 4, .pBindings = bindings};
    expect(vkCreateDescriptorSetLayout(it.w.device, &info, NULL, &it.set_layout), "vkCreateDescriptorSetLayout");
    const VkPushConstantRange range = {all, 0, 80};
    const VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &it.set_layout,
                                               .pushConstantRangeCount = 1,
                                               .pPushConstantRanges = &range};
    expect(vkCreatePipelineLayout(it.w.device, &layout, NULL, &it.layout), "vkCreatePipelineLayout");
    const VkDescriptorPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = SETS, .poolSizeCount = 4, .pPoolSizes = sizes};
    expect(vkCreateDescriptorPool(it.w.device, &pool, NULL, &it.descriptors), "vkCreateDescriptorPool");
    const VkDescriptorSetLayout layouts[SETS] = {it.set_layout, it.set_layout, it.set_layout, it.set_layout};
    const VkDescriptorSetAllocateInfo sets = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                              .descriptorPool = it.descriptors,
                                              .descriptorSetCount = SETS,
                                              .pSetLayouts = layouts};
    expect(vkAllocateDescriptorSets(it.w.device, &sets, it.sets), "vkAllocateDescriptorSets");
}

void objects_open(bool is_followed)
{
    memset(&it, 0, sizeof it);
    it.is_followed = is_followed;
    it.w.immediate = true;
    window_open(&it.w, 0, 0, 64, 48, false, true, VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    window_opened();
    it.objects = make_frame_objects(&it.w);
    make_commands(&it.w, &it.objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &it.primary);
    make_commands(&it.w, &it.objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &it.own);
    make_commands(&it.w, &it.objects, VK_COMMAND_BUFFER_LEVEL_SECONDARY, SECONDARIES, it.secondaries);
    buffers_open();
    for (int i = 0; i < 2; i++) {
        const VkFilter filter = i == 0 ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
        const VkSamplerCreateInfo info = {
            .sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO, .magFilter = filter, .minFilter = filter, .maxLod = 4};
        expect(vkCreateSampler(it.w.device, &info, NULL, &it.samplers[i]), "vkCreateSampler");
    }
    descriptors_open();
    for (int i = 0; i < SLOTS; i++)
        image_create(&it.images[i], &kinds[i % KINDS]);
    image_create(&it.images[DUMMY], &kinds[1]);
    image_create(&it.images[OWN_DEPTH], &kinds[2]);
    image_create(&it.images[OWN_SAMPLES], &kinds[3]);
    image_create(&it.images[OWN_DEPTHS], &kinds[4]);
    for (int i = 0; i < SETS; i++)
        set_write(i, DUMMY, 0, DUMMY);
    const VkQueryPoolCreateInfo queries = {
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, .queryType = VK_QUERY_TYPE_OCCLUSION, .queryCount = QUERIES};
    expect(vkCreateQueryPool(it.w.device, &queries, NULL, &it.queries), "vkCreateQueryPool");
    it.pass.pipeline = -1;
    it.code = VK_SUCCESS;
}

void objects_close(void)
{
    const VkDevice device = it.w.device;
    vkDeviceWaitIdle(device);
    pipelines_free();
    vkDestroyQueryPool(device, it.queries, NULL);
    for (int i = 0; i < ALL_IMAGES; i++)
        if (i != WINDOW)
            image_free(&it.images[i]);
    vkDestroyDescriptorPool(device, it.descriptors, NULL);
    vkDestroyPipelineLayout(device, it.layout, NULL);
    vkDestroyDescriptorSetLayout(device, it.set_layout, NULL);
    for (int i = 0; i < 2; i++)
        vkDestroySampler(device, it.samplers[i], NULL);
    for (int i = 0; i < BUFFERS; i++)
        free_block(&it.w, &it.buffers[i]);
    free_block(&it.w, &it.indices);
    free_block(&it.w, &it.indirect);
    free_block(&it.w, &it.read);
    free_frame_objects(&it.w, &it.objects);
    window_close(&it.w);
}

static unsigned long long digest_of(const unsigned char *bytes, size_t size, unsigned long long all)
{
    for (size_t i = 0; i < size; i++)
        all = (all ^ bytes[i]) * 0x100000001b3ULL;
    return all;
}

/* Digest of all levels and aspects. 0 if the image has several samples. */
unsigned long long image_digest(int number)
{
    const slot_image *image = &it.images[number];
    const image_kind *kind = image->kind;
    VkDeviceSize used = 0;
    if (kind->samples != VK_SAMPLE_COUNT_1_BIT)
        return 0;
    submit(false);
    own_commands_begin();
    if (number == WINDOW)
        image_layout(it.own, image, it.window_layout, VK_IMAGE_LAYOUT_GENERAL);
    for (VkImageAspectFlags aspect = COLOR; aspect <= STENCIL; aspect <<= 1) {
        for (uint32_t level = 0; level < kind->levels && (kind->aspects & aspect) != 0; level++) {
            const VkExtent3D size = {kind->width >> level, kind->height >> level, 1};
            const VkBufferImageCopy region = {
                .bufferOffset = used, .imageSubresource = {aspect, level, 0, 1}, .imageExtent = size};
            vkCmdCopyImageToBuffer(it.own, image->image, VK_IMAGE_LAYOUT_GENERAL, it.read.buffer, 1, &region);
            used += (VkDeviceSize)size.width * size.height * (aspect == STENCIL ? 1 : kind->texel);
        }
    }
    if (number == WINDOW)
        it.window_layout = VK_IMAGE_LAYOUT_GENERAL;
    own_commands_end();
    return digest_of(it.read.bytes, used, 0xcbf29ce484222325ULL);
}

unsigned long long buffers_digest(void)
{
    unsigned long long all = 0xcbf29ce484222325ULL;
    submit(false);
    for (int i = 0; i < BUFFERS; i++)
        all = digest_of(it.buffers[i].bytes, BUFFER_SIZE, all);
    return all;
}
