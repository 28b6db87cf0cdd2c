//! Arrays of a scene file, and references into them, by index or, in older files, by name.

use serde::de::{
    Deserialize, Deserializer, MapAccess, SeqAccess, Visitor, value::MapAccessDeserializer,
};
use std::{fmt, marker::PhantomData};

/// An array, or an object whose keys are names.
#[derive(Debug)]
pub(super) struct Collection<T> {
    /// Items in the order of the file, each with its key if there is one.
    pub items: Vec<(Option<String>, T)>,
}

impl<T> Default for Collection<T> {
    fn default() -> Self {
        Self { items: Vec::new() }
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Collection<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Items<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for Items<T> {
            type Value = Collection<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an array, or an object whose keys are names")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut array: A) -> Result<Self::Value, A::Error> {
                let mut items = Vec::new();
                while let Some(item) = array.next_element()? {
                    items.push((None, item));
                }
                Ok(Collection { items })
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut items = Vec::new();
                while let Some((name, item)) = map.next_entry()? {
                    items.push((Some(name), item));
                }
                Ok(Collection { items })
            }
        }

        deserializer.deserialize_any(Items(PhantomData))
    }
}

/// Deserializes an object. Derived implementations would accept an array of the fields as well.
pub(super) fn object<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<T, D::Error> {
    struct Fields<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Fields<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("an object")
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
            T::deserialize(MapAccessDeserializer::new(map))
        }
    }

    deserializer.deserialize_map(Fields(PhantomData))
}

/// Deserializes a collection of objects.
pub(super) fn items<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Collection<T>, D::Error> {
    struct Item<T>(T);

    impl<'de, T: Deserialize<'de>> Deserialize<'de> for Item<T> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            object(deserializer).map(Self)
        }
    }

    let collection = Collection::<Item<T>>::deserialize(deserializer)?;
    let items = collection.items.into_iter().map(|(key, item)| (key, item.0)).collect();
    Ok(Collection { items })
}

/// Deserializes a collection whose items are objects or names of files.
pub(super) fn items_or_files<'de, D, T>(deserializer: D) -> Result<Collection<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de> + From<String>,
{
    struct Item<T>(T);

    impl<'de, T: Deserialize<'de> + From<String>> Deserialize<'de> for Item<T> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            struct Either<T>(PhantomData<T>);

            impl<'de, T: Deserialize<'de> + From<String>> Visitor<'de> for Either<T> {
                type Value = T;

                fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                    f.write_str("an object or the name of a file")
                }

                fn visit_str<E>(self, name: &str) -> Result<T, E> {
                    Ok(T::from(name.to_owned()))
                }

                fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
                    T::deserialize(MapAccessDeserializer::new(map))
                }
            }

            deserializer.deserialize_any(Either(PhantomData)).map(Self)
        }
    }

    let collection = Collection::<Item<T>>::deserialize(deserializer)?;
    let items = collection.items.into_iter().map(|(key, item)| (key, item.0)).collect();
    Ok(Collection { items })
}

/// An index or a name. yocto-gl writes -1 or an empty name for no reference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Reference {
    Index(i64),
    Name(String),
}

impl<'de> Deserialize<'de> for Reference {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;

        impl Visitor<'_> for Either {
            type Value = Reference;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an index or a name")
            }

            fn visit_i64<E>(self, index: i64) -> Result<Reference, E> {
                Ok(Reference::Index(index))
            }

            fn visit_u64<E>(self, index: u64) -> Result<Reference, E> {
                Ok(Reference::Index(i64::try_from(index).unwrap_or(i64::MAX)))
            }

            fn visit_str<E>(self, name: &str) -> Result<Reference, E> {
                Ok(Reference::Name(name.to_owned()))
            }
        }

        deserializer.deserialize_any(Either)
    }
}
