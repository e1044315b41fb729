//! Compiles compute modules by the first Vulkan driver, and reads the driver's statistics of the result.

use std::{collections::BTreeMap, error::Error, ffi::CString};

use ash::{
    khr::{acceleration_structure, deferred_host_operations, pipeline_executable_properties, ray_query},
    vk,
};

/// A device that compiles. It runs nothing, so it needs no hardware.
pub struct Driver {
    _entry: ash::Entry,
    device: ash::Device,
    statistics: pipeline_executable_properties::Device,
    /// Names of the device and of its driver's version.
    pub name: String,
}

impl Driver {
    /// Opens the first device.
    ///
    /// # Errors
    /// If there is no Vulkan, or no device with pipeline statistics.
    pub fn new() -> Result<Self, Box<dyn Error>> {
        // SAFETY: the loader stays alive in `_entry`; all structures outlive the calls that they are passed to.
        unsafe {
            let entry = ash::Entry::load()?;
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&info, None)?;
            let physical = *instance.enumerate_physical_devices()?.first().ok_or("Vulkan has no device")?;
            let mut driver = vk::PhysicalDeviceDriverProperties::default();
            let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
            instance.get_physical_device_properties2(physical, &mut properties);
            let name = properties.properties.device_name_as_c_str()?.to_string_lossy().into_owned();
            let name = format!("{name}, {}", driver.driver_info_as_c_str()?.to_string_lossy());
            let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
            let extensions = [
                pipeline_executable_properties::NAME,
                acceleration_structure::NAME,
                deferred_host_operations::NAME,
                ray_query::NAME,
            ]
            .map(std::ffi::CStr::as_ptr);
            let mut reports =
                vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default().pipeline_executable_info(true);
            let mut memory =
                vk::PhysicalDeviceVulkan12Features::default().vulkan_memory_model(true).buffer_device_address(true);
            let mut scenes = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true);
            let mut queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
            let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&extensions);
            let info = info.push_next(&mut reports).push_next(&mut memory);
            let info = info.push_next(&mut scenes).push_next(&mut queries);
            let device = instance.create_device(physical, &info, None)?;
            let statistics = pipeline_executable_properties::Device::new(&instance, &device);
            Ok(Self { _entry: entry, device, statistics, name })
        }
    }

    /// Compiles a module with one entry point. Returns the driver's statistics by name.
    ///
    /// # Errors
    /// If naga or the driver refuses it.
    pub fn compile(&self, wgsl: &str) -> Result<BTreeMap<String, u64>, Box<dyn Error>> {
        let module = naga::front::wgsl::parse_str(wgsl)?;
        let flags = naga::valid::ValidationFlags::all();
        let info = naga::valid::Validator::new(flags, naga::valid::Capabilities::all()).validate(&module)?;
        let (module, info) =
            naga::back::pipeline_constants::process_overrides(&module, &info, None, &Default::default())?;
        let entry = CString::new(module.entry_points[0].name.as_str())?;
        let options = naga::back::spv::Options { lang_version: (1, 4), ..Default::default() };
        let stage = naga::back::spv::PipelineOptions {
            shader_stage: naga::ShaderStage::Compute,
            entry_point: module.entry_points[0].name.clone(),
        };
        let code = naga::back::spv::write_vec(&module, &info, &options, Some(&stage))?;
        let bindings = Vec::from_iter(module.global_variables.iter().filter_map(|(_, variable)| {
            let binding = variable.binding.as_ref()?.binding;
            Some((binding, kind(&variable.space, &module.types[variable.ty].inner)))
        }));
        self.statistics_of(&code, &entry, &bindings)
    }

    fn statistics_of(
        &self,
        code: &[u32],
        entry: &CString,
        bindings: &[(u32, vk::DescriptorType)],
    ) -> Result<BTreeMap<String, u64>, Box<dyn Error>> {
        let device = &self.device;
        let bindings = Vec::from_iter(bindings.iter().map(|&(binding, kind)| {
            let layout = vk::DescriptorSetLayoutBinding::default().binding(binding).descriptor_type(kind);
            layout.descriptor_count(1).stage_flags(vk::ShaderStageFlags::COMPUTE)
        }));
        // SAFETY: all objects belong to this device, and are destroyed once after their last use.
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            let set = device.create_descriptor_set_layout(&info, None)?;
            let sets = [set];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            let layout = device.create_pipeline_layout(&info, None)?;
            let module = device.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(code), None)?;
            let stage = vk::PipelineShaderStageCreateInfo::default().stage(vk::ShaderStageFlags::COMPUTE);
            let info = vk::ComputePipelineCreateInfo::default().stage(stage.module(module).name(entry)).layout(layout);
            let info = info.flags(vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR);
            let pipelines = device.create_compute_pipelines(vk::PipelineCache::null(), &[info], None);
            let pipeline = pipelines.map_err(|(_, error)| error)?[0];
            let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline);
            let found = self.statistics.get_pipeline_executable_statistics(&info);
            device.destroy_pipeline(pipeline, None);
            device.destroy_shader_module(module, None);
            device.destroy_pipeline_layout(layout, None);
            device.destroy_descriptor_set_layout(set, None);
            let value = |one: &vk::PipelineExecutableStatisticKHR<'_>| {
                Ok((one.name_as_c_str()?.to_string_lossy().into_owned(), one.value.u64))
            };
            found?.iter().map(value).collect()
        }
    }
}

fn kind(space: &naga::AddressSpace, ty: &naga::TypeInner) -> vk::DescriptorType {
    match (space, ty) {
        (naga::AddressSpace::Uniform, _) => vk::DescriptorType::UNIFORM_BUFFER,
        (naga::AddressSpace::Storage { .. }, _) => vk::DescriptorType::STORAGE_BUFFER,
        (_, naga::TypeInner::Image { class: naga::ImageClass::Storage { .. }, .. }) => {
            vk::DescriptorType::STORAGE_IMAGE
        }
        (_, naga::TypeInner::Image { .. }) => vk::DescriptorType::SAMPLED_IMAGE,
        (_, naga::TypeInner::AccelerationStructure { .. }) => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        _ => vk::DescriptorType::SAMPLER,
    }
}
