//! Selection of the adapter.

use crate::Error;

/// Name of the environment variable that [`Adapter::FromEnv`] reads: `software`, or a part of an adapter's name. wgpu's
/// own `WGPU_BACKEND` restricts every choice to a backend: `vulkan`, `gl`, `dx12` or `metal`.
pub const ADAPTER_VARIABLE: &str = "STEREOTRACE_ADAPTER";

/// The graphics adapter to open ([`Gpu::open`](crate::Gpu::open)).
///
/// A text converts to an adapter by the same rules as the variable: `software` gives [`Adapter::Software`], and any
/// other text gives [`Adapter::Named`]. A browser offers one adapter, usually without a name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Adapter {
    /// The fastest kind available, in the order discrete, integrated, virtual, unknown, software.
    Fastest,
    /// An adapter that runs on the CPU.
    Software,
    /// An adapter whose name contains this text, regardless of case.
    Named(String),
    /// The adapter named by the environment variable `STEREOTRACE_ADAPTER` ([`ADAPTER_VARIABLE`]); [`Adapter::Fastest`]
    /// if it is not set, as in browsers.
    #[default]
    FromEnv,
}

impl From<&str> for Adapter {
    fn from(text: &str) -> Self {
        if text == "software" { Self::Software } else { Self::Named(text.into()) }
    }
}

impl From<String> for Adapter {
    fn from(text: String) -> Self {
        Self::from(text.as_str())
    }
}

impl Adapter {
    /// Returns the first matching adapter of the fastest kind.
    pub(super) async fn find(self) -> Result<wgpu::Adapter, Error> {
        self.find_by(std::env::var(ADAPTER_VARIABLE).ok().as_deref()).await
    }

    async fn find_by(self, variable: Option<&str>) -> Result<wgpu::Adapter, Error> {
        let enabled = wgpu::Instance::enabled_backend_features();
        let mut names = Vec::new();
        let wanted = self.resolved(variable);
        // wgpu panics without a backend.
        if !enabled.is_empty() {
            for backends in tries() {
                let mut adapters = offered(backends).await;
                // The sort is stable: adapters of one kind keep the driver's order.
                adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
                names.extend(adapters.iter().map(|adapter| describe(&adapter.get_info())));
                if let Some(adapter) = adapters.into_iter().find(|adapter| wanted.fits(&adapter.get_info())) {
                    return Ok(adapter);
                }
            }
        }
        Err(Error::NoAdapter {
            wanted: self.asked(variable, std::env::var("WGPU_BACKEND").ok().as_deref()),
            reason: there_are(enabled, &names),
        })
    }

    /// Returns the adapter to look for, given the value of the environment variable.
    fn resolved(&self, variable: Option<&str>) -> Self {
        match (self, variable) {
            (Self::FromEnv, Some(variable)) => Self::from(variable),
            (Self::FromEnv, None) => Self::Fastest,
            (given, _) => given.clone(),
        }
    }

    fn fits(&self, info: &wgpu::AdapterInfo) -> bool {
        match self {
            Self::Fastest | Self::FromEnv => true,
            Self::Software => info.device_type == wgpu::DeviceType::Cpu,
            Self::Named(name) => info.name.to_lowercase().contains(&name.to_lowercase()),
        }
    }

    /// Describes the request for error messages.
    fn asked(&self, variable: Option<&str>, backend: Option<&str>) -> String {
        let adapter = match self {
            Self::Fastest => None,
            Self::Software => Some("the kind 'software'".into()),
            Self::Named(name) => Some(format!("the name '{name}'")),
            Self::FromEnv => variable.map(|variable| format!("{ADAPTER_VARIABLE}={variable}")),
        };
        let rules: Vec<_> =
            adapter.into_iter().chain(backend.map(|backend| format!("WGPU_BACKEND={backend}"))).collect();
        if rules.is_empty() { String::new() } else { format!(" for {}", rules.join(", ")) }
    }
}

/// Returns sets of backends to try in turn. OpenGL comes last: it offers the same hardware again with fewer features,
/// and looking for it can make the driver print to the terminal.
fn tries() -> Vec<wgpu::Backends> {
    let chosen = wgpu::Backends::from_env();
    chosen.map_or_else(|| vec![wgpu::Backends::PRIMARY, wgpu::Backends::GL], |backends| vec![backends])
}

/// Returns the adapters of these backends.
async fn offered(backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = backends;
    // wgpu checks the arguments of each indirect dispatch by a dispatch of its own. All arguments are ours and within
    // every device's limits (shaders/shared/lists.wgsl).
    if std::env::var_os("WGPU_VALIDATION_INDIRECT_CALL").is_none() {
        descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    }
    let instance = wgpu::Instance::new(descriptor);
    if cfg!(target_arch = "wasm32") {
        // A browser offers no list of adapters. It returns the most suitable one.
        let power_preference = wgpu::PowerPreference::HighPerformance;
        let options = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
        return instance.request_adapter(&options).await.into_iter().collect();
    }
    instance.enumerate_adapters(backends).await
}

/// Explains why no adapter was found.
fn there_are(enabled: wgpu::Backends, names: &[String]) -> String {
    match names {
        [] if enabled.is_empty() => {
            "this build has no backend; build it with the feature `native`, or `webgpu` for browsers".into()
        }
        [] if enabled == wgpu::Backends::BROWSER_WEBGPU => "the browser offers no WebGPU adapter".into(),
        [] => "no Vulkan, Metal, DirectX 12 or OpenGL driver offers one".into(),
        names => format!("available: {}", names.join(", ")),
    }
}

pub(super) fn describe(info: &wgpu::AdapterInfo) -> String {
    format!("{} ({:?}, {:?})", info.name, info.device_type, info.backend).trim().into()
}

fn rank(kind: wgpu::DeviceType) -> u32 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(adapter: Adapter, variable: Option<&str>) -> Result<wgpu::AdapterInfo, Error> {
        pollster::block_on(adapter.find_by(variable)).map(|adapter| adapter.get_info())
    }

    /// Returns the adapter that tests run on.
    fn own() -> wgpu::AdapterInfo {
        let variable = std::env::var(ADAPTER_VARIABLE).unwrap_or_else(|_| "software".into());
        found(variable.into(), None).unwrap()
    }

    #[test]
    fn each_way_to_ask_finds_what_it_says() {
        let own = own();
        let name = own.name.to_uppercase();
        let not_there = Some("no such adapter");
        assert_eq!(found(Adapter::Named(name.clone()), not_there).unwrap().name, own.name);
        assert_eq!(found(Adapter::FromEnv, Some(&name)).unwrap().name, own.name);
        if own.device_type == wgpu::DeviceType::Cpu {
            for (adapter, variable) in [(Adapter::Software, not_there), (Adapter::FromEnv, Some("software"))] {
                assert_eq!(found(adapter, variable).unwrap().device_type, own.device_type);
            }
        }
        let fastest = found(Adapter::Fastest, not_there).unwrap();
        assert!(rank(fastest.device_type) <= rank(own.device_type));
        assert_eq!(found(Adapter::FromEnv, None).unwrap().name, fastest.name);
    }

    #[test]
    fn software_is_a_kind_and_all_else_is_part_of_a_name() {
        let of = |device_type, name: &str| wgpu::AdapterInfo {
            name: name.into(),
            ..wgpu::AdapterInfo::new(device_type, wgpu::Backend::Vulkan)
        };
        let kinds = [wgpu::DeviceType::Cpu, wgpu::DeviceType::Other, wgpu::DeviceType::DiscreteGpu];
        let mut infos = kinds.map(|kind| of(kind, "A software company's"));
        let fitting = |text: &str| infos.iter().map(|info| Adapter::from(text).fits(info)).collect::<Vec<_>>();
        assert_eq!(fitting("software"), [true, false, false]);
        assert_eq!(fitting("Software"), [true; 3]);
        assert_eq!(fitting("company's own"), [false; 3]);
        infos.sort_by_key(|info| rank(info.device_type));
        assert_eq!(infos[0].device_type, wgpu::DeviceType::DiscreteGpu);
    }

    #[test]
    fn an_adapter_that_is_not_there_is_an_error_that_names_those_that_are() {
        let (name, own) = ("no such adapter", own().name);
        for (adapter, variable, asked) in [
            (Adapter::from(name), None, "for the name 'no such adapter'"),
            (Adapter::FromEnv, Some(name), "for STEREOTRACE_ADAPTER=no such adapter"),
        ] {
            let error = found(adapter, variable).unwrap_err();
            let message = error.to_string();
            assert!(matches!(error, Error::NoAdapter { .. }), "{message}");
            assert!([asked, "available: ", &own].iter().all(|part| message.contains(part)), "{message}");
        }
    }

    #[test]
    fn messages_say_which_rules_left_no_adapter() {
        let named = Adapter::Named("x".into());
        assert_eq!(Adapter::FromEnv.asked(None, None), "");
        assert_eq!(Adapter::Fastest.asked(Some("x"), Some("gl")), " for WGPU_BACKEND=gl");
        assert_eq!(Adapter::FromEnv.asked(Some("x"), Some("gl")), " for STEREOTRACE_ADAPTER=x, WGPU_BACKEND=gl");
        assert_eq!(named.asked(Some("y"), Some("gl")), " for the name 'x', WGPU_BACKEND=gl");
        assert_eq!(Adapter::Software.asked(None, None), " for the kind 'software'");
    }

    #[test]
    fn messages_say_what_is_missing_where_nothing_is_found() {
        let of = |enabled| there_are(enabled, &[]);
        assert!(of(wgpu::Backends::empty()).contains("the feature `native`"));
        assert!(of(wgpu::Backends::BROWSER_WEBGPU).contains("the browser"));
        assert!(of(wgpu::Backends::VULKAN).contains("no Vulkan"));
        assert_eq!(there_are(wgpu::Backends::VULKAN, &["a".into(), "b".into()]), "available: a, b");
    }
}
